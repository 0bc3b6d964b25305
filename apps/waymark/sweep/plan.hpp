// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace waymark::sweep {

/// A figure of every run, and what is expected of it.
struct Score {
  enum class Judged { by_median, by_worst, by_mean };

  std::string name;  ///< with its unit, as the head of a column
  std::string path;  ///< in the result of a task: "evaluate.trajectory.ate_rms_m", "command.found", "run.cpu_s"
  std::optional<double> at_most;
  std::optional<double> at_least;
  Judged judged = Judged::by_median;
};

/// A row of the table, run with every seed: a configuration with some values, or a command.
struct Variant {
  std::string name;
  std::filesystem::path config;        ///< empty: a command instead
  std::vector<std::string> overrides;  ///< as of `waymark run --set`; {seed} and {out}: the seed, the run's folder
  std::vector<std::string> evaluate;   ///< options of `waymark evaluate`, behind those of the plan
  /// A program and its arguments, {seed}, {out} and {waymark} in them; its last line of output is a JSON object. A
  /// program with a slash is relative to the directory of the process, as `config`; another one is looked up in PATH.
  std::vector<std::string> command = {};
};

/// One run of a study. Tasks are numbered from 0 on in the order of variants, then seeds.
struct Task {
  std::size_t number = 0;
  std::size_t variant = 0;
  std::uint64_t seed = 1;
};

/// A study: which configurations are run with which values and seeds, and what is compared.
struct Plan {
  std::filesystem::path file;
  std::string title;
  std::string about;  ///< a text for the page; may be empty
  std::vector<Variant> variants;
  std::vector<std::uint64_t> seeds;
  std::vector<std::string> evaluate;  ///< options of `waymark evaluate`; {out} stands for the folder of the run
  std::vector<Score> scores;
  int threads = 1;  ///< of each run

  /// Reads the YAML. Throws ConfigError.
  static Plan read(const std::filesystem::path& file);

  std::vector<Task> tasks() const;
};

}  // namespace waymark::sweep
