// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/waymark/command/batch.hpp"
#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/jobs/jobs.hpp"
#include "apps/waymark/sweep/child_process.hpp"
#include "apps/waymark/sweep/drift.hpp"
#include "apps/waymark/sweep/slurm.hpp"
#include "apps/waymark/sweep/study_page.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::command {

namespace {

struct SweepOptions {
  std::filesystem::path plan;
  std::filesystem::path out;  // empty: out/<name of the plan>
  std::filesystem::path page;
  std::filesystem::path check;
  std::optional<std::size_t> task;
  int jobs = 0;  // 0: not given
  bool slurm = false;
  bool collect = false;
};

/// The program that runs, for the processes of the tasks.
std::filesystem::path this_program() { return std::filesystem::read_symlink("/proc/self/exe"); }

void run_tasks(const sweep::Study& study, const std::vector<sweep::Task>& tasks, int jobs) {
  jobs::run_all(
      tasks.size(), jobs, [&](std::size_t i) { study.run(tasks[i]); },
      [&](std::size_t ended) { report_ended(ended, tasks.size(), "runs"); });
}

std::string command_of(const SweepOptions& options) {
  std::string text = options.plan.string();
  if (!options.page.empty()) text += fmt::format(" --page {}", options.page.string());
  return text;
}

/// The page, or its part of the page that a person wrote, and the values beside it.
void write_page(const sweep::Study& study, const sweep::Summary& summary, const std::filesystem::path& page,
                const std::string& command) {
  std::filesystem::path values = page;
  std::optional<std::string> text = sweep::inserted(sweep::read_all(page), study, summary, command);
  if (text) {
    values.replace_filename(study.plan().file.stem());
  } else {
    text = sweep::to_markdown(study, summary, command);
  }
  write_file(page, *text, Belongs::to_nobody);
  write_file(values.replace_extension(".json"), sweep::to_json(study, command), Belongs::to_nobody);
}

/// Throws if the page cannot be written at the end, before hours of runs.
void require_writable(const sweep::Study& study, const std::filesystem::path& page) {
  const std::string text = sweep::read_all(page);
  if (sweep::inserted(text, study, {}, "")) return;
  if (text.find("<!-- study: ") != std::string::npos)
    throw Error(
        fmt::format("{}: has no lines \"<!-- study: {} -->\" and \"<!-- end of study -->\": add them where the table "
                    "belongs, or choose another --page",
                    page.string(), study.plan().file.stem().string()));
  require_replaceable(page, "waymark sweep", "--page");
}

/// Tables of what is there; exit code 0 if all tasks have a result.
int collect(const sweep::Study& study, const SweepOptions& options) {
  const sweep::Summary summary = sweep::summarize(study);
  const std::string command = command_of(options);
  write_file(study.folder() / "study.md", sweep::to_markdown(study, summary, command), Belongs::to_nobody);
  write_file(study.folder() / "study.html", sweep::to_html(study, summary, command), Belongs::to_nobody);
  write_file(study.folder() / "study.json", sweep::to_json(study, command), Belongs::to_nobody);
  if (!options.page.empty()) write_page(study, summary, options.page, command);
  print_output("{}", sweep::to_text(study, summary));
  const std::size_t open = summary.tasks - summary.ended - summary.failures.size();
  print_message("{} of {} runs ended, {} failed, {} open; {}\n", summary.ended, summary.tasks, summary.failures.size(),
                open, (study.folder() / "study.html").string());
  if (!summary.failures.empty())
    print_message("waymark sweep {} runs what failed again; --task {} only that one\n", options.plan.string(),
                  summary.failures.front().task.number);
  return summary.ended == summary.tasks ? kSuccess : kError;
}

int run_one(const sweep::Study& study, std::size_t number) {
  const std::vector<sweep::Task> tasks = study.plan().tasks();
  if (number >= tasks.size())
    throw Error(
        fmt::format("{}: has no task {}; it has {}, from 0 on", study.plan().file.string(), number, tasks.size()));
  const sweep::TaskResult result = study.run(tasks[number]);
  if (result.error.empty()) return kSuccess;
  print_message("waymark: error: task {}: {}\n", number, result.error);
  return kError;
}

int submit(const sweep::Study& study, const SweepOptions& options) {
  const std::vector<sweep::Task> open = study.open_tasks();
  if (open.empty()) return collect(study, options);
  create_folder(study.folder() / "slurm");
  const std::filesystem::path script = study.folder() / "array.sh";
  write_file(script, sweep::array_script(study, this_program(), open, options.jobs), Belongs::to_nobody);
  const std::filesystem::path out = study.folder() / "slurm/sbatch.txt";
  const sweep::Ended ended = sweep::run_program("/usr/bin/env", {"sbatch", script.string()}, out, out);
  const std::string said = sweep::read_all(out);
  if (ended.exit_code != 0)
    throw Error(fmt::format("sbatch {}: exit code {}: {}", script.string(), ended.exit_code, said));
  print_output("{}", said);
  print_message("{} runs are submitted; when they have ended: waymark sweep {} --out {} --collect\n", open.size(),
                options.plan.string(), study.folder().string());
  return kSuccess;
}

int check(const sweep::Study& study, const SweepOptions& options) {
  const std::size_t count = study.plan().variants.size();
  const std::vector<sweep::Drift> drifts =
      sweep::find_drift(study, options.check, [&](std::size_t ended) { report_ended(ended, count, "runs"); });
  for (const sweep::Drift& drift : drifts)
    print_output("{}, seed {}: {}: {}, it was {}\n", drift.variant, drift.seed, drift.score, drift.now, drift.before);
  print_output("{} of {} rows tried; {} values have changed\n", count, count, drifts.size());
  return drifts.empty() ? kSuccess : kError;
}

int run(const SweepOptions& options) {
  sweep::Plan plan = sweep::Plan::read(options.plan);
  std::filesystem::path out = options.out.empty() ? std::filesystem::path("out") / options.plan.stem() : options.out;
  if (!options.check.empty()) out /= "check";
  const sweep::Study study(std::move(plan), out, this_program(), WAYMARK_VERSION);
  if (!options.page.empty()) require_writable(study, options.page);
  if (options.task) return run_one(study, *options.task);
  if (!options.check.empty()) return check(study, options);
  if (options.slurm) return submit(study, options);
  if (!options.collect) {
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    run_tasks(study, study.open_tasks(), options.jobs > 0 ? options.jobs : cores);
  }
  return collect(study, options);
}

}  // namespace

void add_sweep_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SweepOptions>();
  CLI::App* command = app.add_subcommand("sweep", "A study: configurations, values and seeds, with tables and plots");
  command->footer(
      "Example:\n  waymark sweep tests/results/plans/quickstart.yaml --jobs 2\n"
      "  waymark sweep plan.yaml --slurm\n"
      "  waymark sweep plan.yaml --check results.json\n\n"
      "A study that was interrupted goes on where it was; what failed is run again.");
  command->add_option("plan", options->plan, "YAML of the study")->required();
  command->add_option("--out", options->out, "folder of the study (default: out/<name of the plan>)");
  command->add_option("--jobs", options->jobs, "runs at the same time (default: one per core)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--page", options->page, "Markdown file for the tables, with its values as JSON beside it");
  CLI::Option* task = command->add_option("--task", options->task, "runs this task alone, for other batch systems");
  CLI::Option* slurm = command->add_flag("--slurm", options->slurm, "submits the runs as a job array of Slurm");
  CLI::Option* collect = command->add_flag("--collect", options->collect, "runs nothing; tables of the results so far");
  CLI::Option* check =
      command->add_option("--check", options->check, "runs one seed of each row; what differs from this study.json?");
  for (CLI::Option* one : {task, slurm, collect, check}) {
    for (CLI::Option* other : {task, slurm, collect, check}) {
      if (one != other) one->excludes(other);
    }
  }
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace waymark::command
