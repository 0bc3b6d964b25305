// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/sweep/plan.hpp"

namespace waymark::sweep {

/// What a task left: one file, which appears when it is complete.
struct TaskResult {
  std::string identity;                       ///< of the run that made it, see Study
  std::string error;                          ///< why there are no scores; empty: there are
  std::vector<std::optional<double>> values;  ///< of each score; nothing: the run has none
  double wall_s = 0.0;
};

/// The folder of a study: a result for each task that has ended. A result counts as long as the task is the same: its
/// configuration or command (the text and the program's file), values, seed, options, scores and version of waymark. So
/// a study can be interrupted and continued, and after a change of the plan only what changed is run.
class Study {
 public:
  /// `program`: the waymark command. Throws Error if the folder cannot be made.
  Study(Plan plan, std::filesystem::path folder, std::filesystem::path program, std::string version);

  const Plan& plan() const { return plan_; }
  const std::filesystem::path& folder() const { return folder_; }
  const std::string& version() const { return version_; }

  /// Runs a task and writes its result. Only one process may run the same task at a time. Throws Error if the result
  /// cannot be written; what else goes wrong is in the result.
  TaskResult run(const Task& task) const;
  /// The result of a task, nothing if it has none that counts.
  std::optional<TaskResult> result(const Task& task) const;
  /// Tasks without a result, and those that failed.
  std::vector<Task> open_tasks() const;

 private:
  std::string identity(const Task& task) const;
  std::vector<std::string> evaluate_options(const Variant& variant) const;
  std::filesystem::path result_file(const Task& task) const;
  TaskResult score(const Task& task, const std::filesystem::path& out) const;
  TaskResult score_command(const Task& task, const std::filesystem::path& out) const;

  Plan plan_;
  std::filesystem::path folder_;
  std::filesystem::path program_;
  std::string version_;
};

/// The number at a dotted path: names, and for lists an index or the `sensor` or `name` of an element. Nothing if there
/// is none.
std::optional<double> number_at(const nlohmann::json& document, const std::string& path);

}  // namespace waymark::sweep
