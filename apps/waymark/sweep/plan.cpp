// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "apps/waymark/sweep/placeholder.hpp"
#include "waymark/config/config.hpp"

namespace waymark::sweep {

namespace {

constexpr std::int64_t kMostSeeds = 100000;
constexpr std::size_t kMostTasks = 1000000;

/// A number N means the seeds 1 to N; a list is what it says.
std::vector<std::uint64_t> read_seeds(const Config& yaml) {
  const Config::Key key{"seeds", "a number N for the seeds 1 to N, or a list of seeds"};
  std::vector<std::uint64_t> seeds;
  if (yaml.is_list(key)) {
    for (const double seed : yaml.numbers(key)) {
      if (seed < 0.0 || seed > 9e15 || seed != static_cast<double>(static_cast<std::uint64_t>(seed)))
        yaml.fail(key.name, fmt::format("{:g} is no seed: a whole number from 0 on is expected", seed));
      seeds.push_back(static_cast<std::uint64_t>(seed));
    }
    if (seeds.empty()) yaml.fail(key.name, "at least one seed is expected");
    if (std::set(seeds.begin(), seeds.end()).size() != seeds.size()) yaml.fail(key.name, "a seed is given twice");
    return seeds;
  }
  const std::int64_t count = yaml.integer_in(key, 1, kMostSeeds, 10);
  for (std::int64_t seed = 1; seed <= count; ++seed) seeds.push_back(static_cast<std::uint64_t>(seed));
  return seeds;
}

/// A row that is a program.
Variant read_command(const Config& entry) {
  for (const char* key : {"config", "set", "evaluate"}) {
    if (entry.has(key)) entry.fail(key, "a row has a `config` with `set` and `evaluate`, or a `command`, not both");
  }
  Variant variant;
  variant.command = entry.texts(
      {"command",
       "program and arguments, instead of `config`: {seed}, {out} and {waymark} stand for the seed, a folder and this "
       "program; the program is relative to the plan if it has a slash, and its last line of output is a JSON object"});
  if (variant.command.empty() || variant.command.front().empty())
    entry.fail("command", "a program and its arguments are expected");
  std::string& program = variant.command.front();
  if (program.find('/') != std::string::npos) {
    program = (entry.file().parent_path() / program).lexically_normal().string();
    if (program.find('/') == std::string::npos) program.insert(0, "./");
    if (!std::filesystem::is_regular_file(program))
      entry.fail("command", fmt::format("\"{}\" is no file: a program is expected", program));
  }
  const std::string stem = std::filesystem::path(program).stem().string();
  variant.name = entry.text({"name", "", "how it is called in tables", "name of the YAML, or of the program"}, stem);
  return variant;
}

std::vector<Variant> read_configurations(const Config& yaml) {
  std::vector<Variant> variants;
  for (const Config& entry : yaml.items(
           {"runs", "what is compared: `config`, `name`, `set` and `evaluate` of each, or `command` and `name`"})) {
    if (entry.has("command")) {
      variants.push_back(read_command(entry));
      continue;
    }
    Variant variant;
    const std::filesystem::path config = entry.text({"config", "YAML of the robot, relative to the plan"});
    variant.config = (yaml.file().parent_path() / config).lexically_normal();
    if (!std::filesystem::is_regular_file(variant.config))
      entry.fail("config", fmt::format("\"{}\" is no file: the YAML of a robot is expected", variant.config.string()));
    variant.name = entry.text({"name", "", "how it is called in tables", "name of the YAML, or of the program"},
                              config.stem().string());
    variant.overrides = entry.texts(
        {"set", "key=value: overrides keys of the YAML; {seed} and {out} stand for the seed and the run's folder"}, {});
    for (const std::string& one : variant.overrides) {
      if (one.find('=') == std::string::npos) entry.fail("set", fmt::format("\"{}\": key=value is expected", one));
    }
    variant.evaluate = entry.texts({"evaluate", "options of `waymark evaluate` for this row, behind those of all"}, {});
    variants.push_back(std::move(variant));
  }
  if (variants.empty()) yaml.fail("runs", "at least one configuration is expected");
  return variants;
}

/// Every variant with every value of one key.
std::vector<Variant> with_values(const std::vector<Variant>& variants, const Config& vary, const std::string& key,
                                 const std::vector<std::string>& values) {
  std::vector<Variant> result;
  const std::string last = key.substr(key.rfind('.') + 1);
  const std::string place = fmt::format("{{{}}}", key);
  const auto has_place = [&](const std::string& word) { return word.find(place) != std::string::npos; };
  for (const Variant& variant : variants) {
    if (!variant.command.empty() && std::ranges::none_of(variant.command, has_place))
      vary.fail(key, fmt::format("the command of \"{}\" has no {}: there the value is expected", variant.name, place));
    for (const std::string& value : values) {
      Variant& one = result.emplace_back(variant);
      one.name += fmt::format(", {} {}", last, value);
      if (variant.command.empty()) one.overrides.push_back(fmt::format("{}={}", key, value));
      for (std::string& word : one.command) word = filled(word, place, value);
    }
  }
  return result;
}

std::vector<Variant> read_variants(const Config& yaml) {
  std::vector<Variant> variants = read_configurations(yaml);
  const Config vary = yaml.child_or_empty(
      {"vary",
       "keys with lists of values; every combination is run with every row; in a command {key} stands for the value"});
  for (const std::string& key : vary.keys()) {
    const std::vector<std::string> values = vary.texts({key, "values of this key"});
    if (values.empty()) vary.fail(key, "at least one value is expected");
    variants = with_values(variants, vary, key, values);
    if (variants.size() > kMostTasks) vary.fail(key, "more than a million runs");
  }
  std::set<std::string> names;
  for (const Variant& variant : variants) {
    if (!names.insert(variant.name).second)
      yaml.fail("runs", fmt::format("two rows of the table would be called \"{}\"; give them a `name`", variant.name));
  }
  return variants;
}

std::vector<Score> read_scores(const Config& yaml) {
  std::vector<Score> scores;
  for (const Config& entry : yaml.items({"scores", "the columns of the table"})) {
    Score score;
    score.path = entry.text({"path",
                             "number in the result of a run: evaluate.trajectory.ate_rms_m, command.found, run.cpu_s, "
                             "diagnostics.health.lost_s; of a list, the index or the `sensor` of the element"});
    score.name = entry.text({"name", "", "head of the column, with the unit", "the path"}, score.path);
    if (entry.has("at_most")) score.at_most = entry.number({"at_most", "mark: not more than this"});
    if (entry.has("at_least")) score.at_least = entry.number({"at_least", "mark: not less than this"});
    const std::string judged =
        entry.choice({"judged_by", "which value has to reach the mark; with `mean` the table has the mean alone"},
                     {"median", "worst", "mean"}, "median");
    score.judged = judged == "median"  ? Score::Judged::by_median
                   : judged == "worst" ? Score::Judged::by_worst
                                       : Score::Judged::by_mean;
    scores.push_back(std::move(score));
  }
  if (scores.empty()) yaml.fail("scores", "at least one score is expected");
  return scores;
}

}  // namespace

Plan Plan::read(const std::filesystem::path& file) {
  const Config yaml = Config::load(file);
  Plan plan;
  plan.file = file;
  plan.title = yaml.text({"title", "heading of the page"});
  plan.about = yaml.text({"about", "a text for the page"}, "");
  plan.variants = read_variants(yaml);
  plan.seeds = read_seeds(yaml);
  plan.evaluate = yaml.texts({"evaluate", "options of `waymark evaluate`; {out} stands for the folder of the run"}, {});
  const auto is_command = [](const Variant& variant) { return !variant.command.empty(); };
  if (!plan.evaluate.empty() && std::ranges::all_of(plan.variants, is_command))
    yaml.fail("evaluate", "every row is a command: options of `waymark evaluate` need a row with a `config`");
  plan.scores = read_scores(yaml);
  plan.threads = static_cast<int>(yaml.integer_in({"threads", "threads of each run"}, 1, 1024, 1));
  yaml.reject_unread();
  if (plan.variants.size() * plan.seeds.size() > kMostTasks) yaml.fail("seeds", "more than a million runs");
  return plan;
}

std::vector<Task> Plan::tasks() const {
  std::vector<Task> tasks;
  tasks.reserve(variants.size() * seeds.size());
  for (std::size_t variant = 0; variant < variants.size(); ++variant) {
    for (const std::uint64_t seed : seeds) tasks.push_back({tasks.size(), variant, seed});
  }
  return tasks;
}

}  // namespace waymark::sweep
