// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace waymark::sweep {

/// How a program ended.
struct Ended {
  int exit_code = 0;   ///< 128 + the signal's number, if a signal ended it
  double cpu_s = 0.0;  ///< of the program and what it waited for
  double wall_s = 0.0;
};

/// Runs a program to its end, with both outputs into files. Throws Error if it cannot be started.
Ended run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                  const std::filesystem::path& out, const std::filesystem::path& err);

/// What a file contains; empty if there is none.
std::string read_all(const std::filesystem::path& file);

}  // namespace waymark::sweep
