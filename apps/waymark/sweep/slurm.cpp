// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/slurm.hpp"

#include <fmt/format.h>

namespace waymark::sweep {

namespace {

/// A word of the shell, whatever is in it.
std::string quoted(const std::string& word) {
  std::string result = "'";
  for (const char c : word) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      result += c;
    }
  }
  return result + "'";
}

}  // namespace

std::string array_of(const std::vector<Task>& tasks) {
  std::string text;
  for (std::size_t first = 0; first < tasks.size();) {
    std::size_t last = first;
    while (last + 1 < tasks.size() && tasks[last + 1].number == tasks[last].number + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", tasks[first].number);
    if (last > first) text += fmt::format("-{}", tasks[last].number);
    first = last + 1;
  }
  return text;
}

std::string array_script(const Study& study, const std::filesystem::path& program, const std::vector<Task>& tasks,
                         int at_once) {
  const std::filesystem::path folder = std::filesystem::absolute(study.folder()).lexically_normal();
  const std::string limit = at_once > 0 ? fmt::format("%{}", at_once) : "";
  return fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name=waymark-{}\n"
      "#SBATCH --array={}{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --output={}/slurm/%a.txt\n"
      "exec {} sweep {} --out {} --task \"$SLURM_ARRAY_TASK_ID\"\n",
      study.plan().file.stem().string(), array_of(tasks), limit, study.plan().threads, folder.string(),
      quoted(program.string()), quoted(std::filesystem::absolute(study.plan().file).lexically_normal().string()),
      quoted(folder.string()));
}

}  // namespace waymark::sweep
