// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/study_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "apps/waymark/sweep/strip_plot.hpp"
#include "waymark/io/xml_text.hpp"

namespace waymark::sweep {

namespace {

constexpr std::size_t kManyScores = 9;  // do not fit beside each other

/// The head of its column.
std::string head_of(const Score& score) {
  return score.judged == Score::Judged::by_mean ? score.name + ", mean" : score.name;
}

std::string text_of(const Cell& cell) {
  if (cell.values.empty()) return "–";
  if (cell.shows_mean) return fmt::format("{:.3g}", cell.mean);
  if (cell.min == cell.max) return fmt::format("{:.3g}", cell.median);
  return fmt::format("{:.3g} / {:.3g} / {:.3g}", cell.min, cell.median, cell.max);
}

/// "at most 0.15 by the median"; empty without a mark.
std::string mark_of(const Score& score) {
  std::string text;
  if (score.at_least) text = fmt::format("at least {:g}", *score.at_least);
  if (score.at_most) text += fmt::format("{}at most {:g}", text.empty() ? "" : ", ", *score.at_most);
  if (text.empty()) return text;
  if (score.judged == Score::Judged::by_worst) return text + " by every seed";
  return text + (score.judged == Score::Judged::by_mean ? " by the mean" : " by the median");
}

/// One sentence for every score with a mark.
std::vector<std::string> marks(const Plan& plan, const Summary& summary) {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < plan.scores.size(); ++i) {
    const std::string mark = mark_of(plan.scores[i]);
    if (mark.empty()) continue;
    std::string missed;
    std::size_t judged = 0;
    std::size_t reached = 0;
    for (const Line& line : summary.lines) {
      if (!line.cells[i].reached) continue;
      ++judged;
      if (*line.cells[i].reached) {
        ++reached;
      } else {
        missed += fmt::format("{}{}", missed.empty() ? "; not by: " : "; ", line.name);
      }
    }
    sentences.push_back(
        fmt::format("{}, {}: reached by {} of {} rows{}", plan.scores[i].name, mark, reached, judged, missed));
  }
  return sentences;
}

std::string seeds_of(const Line& line, const Plan& plan) {
  return line.ended == plan.seeds.size() ? std::to_string(line.ended)
                                         : fmt::format("{} of {}", line.ended, plan.seeds.size());
}

std::string in_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c;
  }
  return cell;
}

/// The table with its head. A single row with many scores stands upright: a score in each line.
std::vector<std::vector<std::string>> cells_of(const Plan& plan, const Summary& summary) {
  std::vector<std::vector<std::string>> rows{{"run", "seeds"}};
  for (const Score& score : plan.scores) rows.front().push_back(head_of(score));
  for (const Line& line : summary.lines) {
    std::vector<std::string>& row = rows.emplace_back(std::vector{line.name, seeds_of(line, plan)});
    for (const Cell& cell : line.cells) row.push_back(text_of(cell));
  }
  if (rows.size() != 2 || plan.scores.size() < kManyScores) return rows;
  std::vector<std::vector<std::string>> upright;
  upright.reserve(rows.front().size());
  for (std::size_t i = 0; i < rows.front().size(); ++i) upright.push_back({rows[0][i], rows[1][i]});
  return upright;
}

/// Command, table, marks and failures.
std::string tables(const Study& study, const Summary& summary, const std::string& command) {
  const Plan& plan = study.plan();
  std::string page = fmt::format(
      "Made by\n\n    waymark sweep {}\n\nby version {}; {} of {} runs. Over the seeds: min / median / max.\n\n",
      command, study.version(), summary.ended, summary.tasks);
  const std::vector<std::vector<std::string>> cells = cells_of(plan, summary);
  for (std::size_t row = 0; row < cells.size(); ++row) {
    page += '|';
    for (const std::string& cell : cells[row]) page += fmt::format(" {} |", in_cell(cell));
    page += '\n';
    if (row > 0) continue;
    page += '|';
    for (std::size_t i = 0; i < cells[row].size(); ++i) page += "---|";
    page += '\n';
  }
  const std::vector<std::string> sentences = marks(plan, summary);
  if (!sentences.empty()) page += "\nMarks:\n\n";
  for (const std::string& sentence : sentences) page += fmt::format("- {}\n", sentence);
  if (!summary.failures.empty()) page += "\nFailed:\n\n";
  for (const Failure& failure : summary.failures)
    page += fmt::format("- task {} ({}, seed {}): {}\n", failure.task.number, failure.variant, failure.task.seed,
                        failure.error);
  return page;
}

}  // namespace

std::string to_markdown(const Study& study, const Summary& summary, const std::string& command) {
  const Plan& plan = study.plan();
  std::string page = fmt::format("# {}\n\n", plan.title);
  if (!plan.about.empty()) page += plan.about + "\n\n";
  return page + tables(study, summary, command);
}

std::optional<std::string> inserted(const std::string& page, const Study& study, const Summary& summary,
                                    const std::string& command) {
  const std::string begin = fmt::format("<!-- study: {} -->\n", study.plan().file.stem().string());
  const std::string_view end = "<!-- end of study -->";
  const std::size_t from = page.find(begin);
  const std::size_t to = from == std::string::npos ? from : page.find(end, from);
  if (to == std::string::npos) return std::nullopt;
  return page.substr(0, from) + begin + tables(study, summary, command) + page.substr(to);
}

std::string to_html(const Study& study, const Summary& summary, const std::string& command) {
  const Plan& plan = study.plan();
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n<style>\n"
      "body {{ font: 15px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}\n"
      "table {{ border-collapse: collapse; }} th, td {{ border-bottom: 1px solid #ccc; padding: .2em .8em; text-align: "
      "left; }}\n"
      ".missed {{ color: #b00020; }} .reached {{ color: #14692f; }} pre {{ background: #f4f4f4; padding: .6em; "
      "overflow-x: auto; }}\n"
      "</style></head><body>\n<h1>{0}</h1>\n",
      xml_text(plan.title));
  if (!plan.about.empty()) page += fmt::format("<p>{}</p>\n", xml_text(plan.about));
  page += fmt::format(
      "<pre>waymark sweep {}</pre>\n<p>Version {}; {} of {} runs. Over the seeds: min / median / max.</p>\n"
      "<table>\n<tr><th>run</th><th>seeds</th>",
      xml_text(command), study.version(), summary.ended, summary.tasks);
  for (const Score& score : plan.scores) page += fmt::format("<th>{}</th>", xml_text(head_of(score)));
  page += "</tr>\n";
  for (const Line& line : summary.lines) {
    page += fmt::format("<tr><td>{}</td><td>{}</td>", xml_text(line.name), seeds_of(line, plan));
    for (const Cell& cell : line.cells) {
      const std::string_view kind = !cell.reached ? "" : *cell.reached ? " class=\"reached\"" : " class=\"missed\"";
      page += fmt::format("<td{}>{}</td>", kind, text_of(cell));
    }
    page += "</tr>\n";
  }
  page += "</table>\n";
  for (const std::string& sentence : marks(plan, summary)) page += fmt::format("<p>{}</p>\n", xml_text(sentence));
  for (std::size_t i = 0; i < plan.scores.size(); ++i)
    page += fmt::format("<h2>{}</h2>\n{}", xml_text(plan.scores[i].name), strip_plot(plan.scores[i], summary, i));
  for (const Failure& failure : summary.failures)
    page += fmt::format("<p class=\"missed\">task {} ({}, seed {}) failed: {}</p>\n", failure.task.number,
                        xml_text(failure.variant), failure.task.seed, xml_text(failure.error));
  return page + "</body></html>\n";
}

std::string to_text(const Study& study, const Summary& summary) {
  const Plan& plan = study.plan();
  const std::vector<std::vector<std::string>> rows = cells_of(plan, summary);
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) line += fmt::format("{:<{}}  ", row[i], widths[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  for (const std::string& sentence : marks(plan, summary)) text += sentence + '\n';
  for (const Failure& failure : summary.failures)
    text += fmt::format("failed: task {} ({}, seed {}): {}\n", failure.task.number, failure.variant, failure.task.seed,
                        failure.error);
  return text;
}

std::string to_json(const Study& study, const std::string& command) {
  const Plan& plan = study.plan();
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Task& task : plan.tasks()) {
    const std::optional<TaskResult> result = study.result(task);
    if (!result || !result->error.empty()) continue;
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < plan.scores.size(); ++i)
      values[plan.scores[i].path] =
          result->values[i] ? nlohmann::ordered_json(*result->values[i]) : nlohmann::ordered_json(nullptr);
    rows.push_back({{"run", plan.variants[task.variant].name}, {"seed", task.seed}, {"values", std::move(values)}});
  }
  const nlohmann::ordered_json page{
      {"title", plan.title}, {"command", "waymark sweep " + command}, {"version", study.version()}, {"runs", rows}};
  return page.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace waymark::sweep
