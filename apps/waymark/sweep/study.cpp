// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <charconv>
#include <utility>

#include "apps/waymark/sweep/child_process.hpp"
#include "apps/waymark/sweep/placeholder.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::sweep {

namespace {

using Json = nlohmann::json;

constexpr int kSuccess = 0;
constexpr int kLost = 4;  // the run ended, and its results are there

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \n\r");
  if (end == std::string::npos) return {};
  const std::size_t begin = text.rfind('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

std::uint32_t sum_of(const std::filesystem::path& file) {
  const std::string bytes = read_all(file);
  boost::crc_32_type sum;
  sum.process_bytes(bytes.data(), bytes.size());
  return sum.checksum();
}

/// Whether a command names a file, not a program of PATH.
bool is_file(const std::string& program) { return program.find('/') != std::string::npos; }

Json run_part(const Ended& run) { return {{"cpu_s", run.cpu_s}, {"wall_s", run.wall_s}, {"exit_code", run.exit_code}}; }

/// Removes a folder when it goes out of scope.
class Removed {
 public:
  explicit Removed(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~Removed() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Removed(const Removed&) = delete;
  Removed& operator=(const Removed&) = delete;

 private:
  std::filesystem::path folder_;
};

const Json* element_of(const Json& list, const std::string& name) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (error == std::errc() && end == name.data() + name.size()) return index < list.size() ? &list[index] : nullptr;
  for (const Json& element : list) {
    for (const char* key : {"sensor", "name"}) {
      if (element.is_object() && element.contains(key) && element[key] == name) return &element;
    }
  }
  return nullptr;
}

}  // namespace

std::optional<double> number_at(const Json& document, const std::string& path) {
  const Json* at = &document;
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    const std::string name = path.substr(from, dot - from);
    from = dot + 1;
    if (at->is_array()) {
      at = element_of(*at, name);
    } else {
      at = at->is_object() && at->contains(name) ? &(*at)[name] : nullptr;
    }
    if (at == nullptr) return std::nullopt;
  }
  if (at->is_array()) return static_cast<double>(at->size());  // such as the landmarks that were missed
  if (!at->is_number()) return std::nullopt;
  return at->get<double>();
}

Study::Study(Plan plan, std::filesystem::path folder, std::filesystem::path program, std::string version)
    : plan_(std::move(plan)), folder_(std::move(folder)), program_(std::move(program)), version_(std::move(version)) {
  create_folder(folder_ / "results", "folder of the study");
}

std::string Study::identity(const Task& task) const {
  const Variant& variant = plan_.variants[task.variant];
  Json paths = Json::array();
  for (const Score& score : plan_.scores) paths.push_back(score.path);
  if (!variant.command.empty()) {
    const std::filesystem::path program = variant.command.front();
    std::vector<std::string> command = variant.command;
    command.front() = program.filename().string();
    Json identity{{"version", version_}, {"command", command}, {"seed", task.seed}, {"scores", paths}};
    if (is_file(program.string())) identity["command_crc32"] = sum_of(program);
    return identity.dump();
  }
  return Json{{"version", version_},
              {"config", variant.config.filename().string()},
              {"config_crc32", sum_of(variant.config)},
              {"set", variant.overrides},
              {"seed", task.seed},
              {"evaluate", evaluate_options(variant)},
              {"scores", paths}}
      .dump();
}

std::vector<std::string> Study::evaluate_options(const Variant& variant) const {
  std::vector<std::string> options = plan_.evaluate;
  options.insert(options.end(), variant.evaluate.begin(), variant.evaluate.end());
  return options;
}

std::filesystem::path Study::result_file(const Task& task) const {
  return folder_ / "results" / fmt::format("{:06}.json", task.number);
}

TaskResult Study::score_command(const Task& task, const std::filesystem::path& out) const {
  const Variant& variant = plan_.variants[task.variant];
  const std::string& name = variant.command.front();
  const std::filesystem::path run_folder = out / "run";
  create_folder(run_folder);
  std::vector<std::string> words;
  words.reserve(variant.command.size());
  for (const std::string& one : variant.command) {
    const std::string with_seed = filled(one, "{seed}", std::to_string(task.seed));
    words.push_back(filled(filled(with_seed, "{out}", run_folder.string()), "{waymark}", program_.string()));
  }
  std::filesystem::path program = "/usr/bin/env";  // it looks up the first word in PATH
  if (is_file(name)) {
    program = words.front();
    words.erase(words.begin());
  }
  TaskResult result;
  const Ended run = run_program(program, words, out / "command.out", out / "command.err");
  result.wall_s = run.wall_s;
  const std::string file_name = std::filesystem::path(name).filename().string();
  if (run.exit_code != kSuccess) {
    result.error =
        fmt::format("{}: exit code {}: {}", file_name, run.exit_code, last_line(read_all(out / "command.err")));
    return result;
  }
  const std::string line = last_line(read_all(out / "command.out"));
  const Json scores = Json::parse(line, nullptr, false);
  if (!scores.is_object()) {
    result.error = fmt::format("{}: the last line of its output is \"{}\": a JSON object is expected", file_name, line);
    return result;
  }
  const Json document{{"run", run_part(run)}, {"command", scores}};
  for (const Score& one : plan_.scores) result.values.push_back(number_at(document, one.path));
  return result;
}

TaskResult Study::score(const Task& task, const std::filesystem::path& out) const {
  const Variant& variant = plan_.variants[task.variant];
  if (!variant.command.empty()) return score_command(task, out);
  const std::string seed = std::to_string(task.seed);
  const std::filesystem::path run_folder = out / "run";
  std::vector<std::string> arguments{
      "run",       variant.config.string(),       "--out",  run_folder.string(), "--seed", seed,
      "--threads", std::to_string(plan_.threads), "--quiet"};
  for (const std::string& one : variant.overrides) {
    // A full path, though within the folder of the run.
    if (one.find("{out}") != std::string::npos) arguments.emplace_back("--allow-outside");
    arguments.emplace_back("--set");
    arguments.push_back(filled(filled(one, "{seed}", seed), "{out}", run_folder.string()));
  }
  TaskResult result;
  const Ended run = run_program(program_, arguments, out / "run.out", out / "run.err");
  result.wall_s = run.wall_s;
  if (run.exit_code != kSuccess && run.exit_code != kLost) {
    result.error = fmt::format("waymark run: exit code {}: {}", run.exit_code, last_line(read_all(out / "run.err")));
    return result;
  }
  Json document{{"run", run_part(run)}};
  const auto is_asked = [&](std::string_view part) {
    return std::ranges::any_of(plan_.scores, [&](const Score& score) { return score.path.starts_with(part); });
  };
  if (is_asked("evaluate.")) {
    arguments = {"evaluate", run_folder.string(), "--json"};
    for (const std::string& one : evaluate_options(variant))
      arguments.push_back(filled(one, "{out}", run_folder.string()));
    const Ended evaluated = run_program(program_, arguments, out / "evaluate.json", out / "evaluate.err");
    if (evaluated.exit_code != kSuccess) {
      result.error = fmt::format("waymark evaluate: exit code {}: {}", evaluated.exit_code,
                                 last_line(read_all(out / "evaluate.err")));
      return result;
    }
    document["evaluate"] = Json::parse(read_all(out / "evaluate.json"));
  }
  if (is_asked("diagnostics.")) {
    document["diagnostics"] = Json::parse(read_all(run_folder / "diagnostics.json"), nullptr, false);
    if (document["diagnostics"].is_discarded()) {
      result.error = fmt::format("{}: a sink `diagnostics` is expected", variant.config.string());
      return result;
    }
  }
  for (const Score& one : plan_.scores) result.values.push_back(number_at(document, one.path));
  return result;
}

TaskResult Study::run(const Task& task) const {
  const std::filesystem::path out = folder_ / "running" / fmt::format("{:06}", task.number);
  std::filesystem::remove_all(out);  // of a task that was interrupted
  create_folder(out);
  const Removed removed(out);
  TaskResult result;
  try {
    result = score(task, out);
  } catch (const std::exception& error) {
    result.error = error.what();
  }
  result.identity = identity(task);
  Json values = Json::array();
  for (const std::optional<double>& value : result.values) values.push_back(value ? Json(*value) : Json(nullptr));
  const Json file{
      {"task", Json::parse(result.identity)}, {"error", result.error}, {"values", values}, {"wall_s", result.wall_s}};
  write_file(result_file(task), file.dump(1, ' ', false, Json::error_handler_t::replace) + '\n', Belongs::to_nobody);
  return result;
}

std::optional<TaskResult> Study::result(const Task& task) const {
  const Json file = Json::parse(read_all(result_file(task)), nullptr, false);
  if (!file.is_object() || !file.contains("task") || !file.contains("values")) return std::nullopt;
  TaskResult result;
  result.identity = file["task"].dump();
  if (result.identity != identity(task)) return std::nullopt;
  result.error = file.value("error", "");
  result.wall_s = file.value("wall_s", 0.0);
  for (const Json& value : file["values"])
    result.values.push_back(value.is_number() ? std::optional(value.get<double>()) : std::nullopt);
  if (result.error.empty() && result.values.size() != plan_.scores.size()) return std::nullopt;
  return result;
}

std::vector<Task> Study::open_tasks() const {
  std::vector<Task> open;
  for (const Task& task : plan_.tasks()) {
    const std::optional<TaskResult> found = result(task);
    if (!found || !found->error.empty()) open.push_back(task);
  }
  return open;
}

}  // namespace waymark::sweep
