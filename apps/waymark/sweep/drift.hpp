// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/waymark/sweep/study.hpp"

namespace waymark::sweep {

/// A value that is not what it was.
struct Drift {
  std::string variant;
  std::uint64_t seed = 0;
  std::string score;
  std::string before;  ///< "–" if there was none
  std::string now;
};

/// Runs one seed of every variant again and compares it with the values of an earlier study (`to_json`). CPU and wall
/// times are not compared. `task_ended` is called after each. Throws Error if the file cannot be read, has other
/// variants or a task fails.
std::vector<Drift> find_drift(const Study& study, const std::filesystem::path& earlier,
                              const std::function<void(std::size_t ended)>& task_ended);

}  // namespace waymark::sweep
