// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/summary.hpp"

#include <algorithm>
#include <numeric>

#include "apps/waymark/evaluation/trajectory_error.hpp"

namespace waymark::sweep {

namespace {

void conclude(Cell& cell, const Score& score) {
  if (cell.values.empty()) return;
  cell.min = *std::ranges::min_element(cell.values);
  cell.max = *std::ranges::max_element(cell.values);
  cell.median = evaluation::median_of(cell.values);
  cell.mean = std::accumulate(cell.values.begin(), cell.values.end(), 0.0) / static_cast<double>(cell.values.size());
  cell.shows_mean = score.judged == Score::Judged::by_mean;
  if (!score.at_most && !score.at_least) return;
  const bool by_worst = score.judged == Score::Judged::by_worst;
  const double middle = cell.shows_mean ? cell.mean : cell.median;
  cell.reached = (!score.at_most || (by_worst ? cell.max : middle) <= *score.at_most) &&
                 (!score.at_least || (by_worst ? cell.min : middle) >= *score.at_least);
}

}  // namespace

Summary summarize(const Study& study) {
  const Plan& plan = study.plan();
  Summary summary;
  for (const Variant& variant : plan.variants)
    summary.lines.push_back({variant.name, 0, std::vector<Cell>(plan.scores.size())});
  for (const Task& task : plan.tasks()) {
    ++summary.tasks;
    const std::optional<TaskResult> result = study.result(task);
    if (!result) continue;
    Line& line = summary.lines[task.variant];
    if (!result->error.empty()) {
      summary.failures.push_back({task, line.name, result->error});
      continue;
    }
    ++summary.ended;
    ++line.ended;
    for (std::size_t i = 0; i < plan.scores.size(); ++i) {
      if (result->values[i]) line.cells[i].values.push_back(*result->values[i]);
    }
  }
  for (Line& line : summary.lines) {
    for (std::size_t i = 0; i < plan.scores.size(); ++i) conclude(line.cells[i], plan.scores[i]);
  }
  return summary;
}

}  // namespace waymark::sweep
