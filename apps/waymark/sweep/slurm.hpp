// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/waymark/sweep/study.hpp"

namespace waymark::sweep {

/// Numbers as an array job of Slurm takes them: "0-3,7".
std::string array_of(const std::vector<Task>& tasks);

/// A job array of Slurm that runs the tasks: each is `program sweep PLAN --out FOLDER --task N`. `at_once`: how many
/// may run at the same time; 0: as many as the cluster permits.
std::string array_script(const Study& study, const std::filesystem::path& program, const std::vector<Task>& tasks,
                         int at_once);

}  // namespace waymark::sweep
