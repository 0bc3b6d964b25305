// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/drift.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "waymark/base/error.hpp"

namespace waymark::sweep {

namespace {

using Json = nlohmann::json;

/// The values of a run in the earlier study.
const Json& values_of(const Json& earlier, const Variant& variant, std::uint64_t seed,
                      const std::filesystem::path& file) {
  for (const Json& run : earlier.at("runs")) {
    if (run.at("run") == variant.name && run.at("seed") == seed) return run.at("values");
  }
  throw Error(
      fmt::format("{}: has no run \"{}\" with seed {}; the plan has changed since", file.string(), variant.name, seed));
}

std::string text_of(const std::optional<double>& value) { return value ? fmt::format("{:.6g}", *value) : "–"; }

/// Equal but for how a number is written.
bool is_same(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return std::abs(*a - *b) <= 1e-9 * std::max(std::abs(*a), std::abs(*b));
}

bool is_time(const std::string& path) { return path.ends_with(".cpu_s") || path.ends_with(".wall_s"); }

}  // namespace

std::vector<Drift> find_drift(const Study& study, const std::filesystem::path& earlier,
                              const std::function<void(std::size_t)>& task_ended) {
  std::ifstream stream(earlier);
  const Json file = Json::parse(stream, nullptr, false);
  if (!file.is_object() || !file.contains("runs"))
    throw Error(fmt::format("{}: the study.json of an earlier study is expected", earlier.string()));
  std::vector<Drift> drifts;
  std::size_t ended = 0;
  for (const Task& task : study.plan().tasks()) {
    if (task.seed != study.plan().seeds.front()) continue;
    const Variant& variant = study.plan().variants[task.variant];
    const Json& before = values_of(file, variant, task.seed, earlier);
    const TaskResult now = study.run(task);
    if (!now.error.empty()) throw Error(fmt::format("{}, seed {}: {}", variant.name, task.seed, now.error));
    for (std::size_t i = 0; i < study.plan().scores.size(); ++i) {
      const Score& score = study.plan().scores[i];
      if (is_time(score.path)) continue;
      std::optional<double> was;
      if (before.contains(score.path) && before[score.path].is_number()) was = before[score.path].get<double>();
      if (!is_same(was, now.values[i]))
        drifts.push_back({variant.name, task.seed, score.name, text_of(was), text_of(now.values[i])});
    }
    task_ended(++ended);
  }
  return drifts;
}

}  // namespace waymark::sweep
