// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/flight_record.hpp"
#include "apps/waymark/command/progress.hpp"
#include "apps/waymark/command/run_log.hpp"
#include "waymark/host/session.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::command {

namespace {

std::atomic<bool> interrupted{false};

/// Events that a running robot's report repeats and that are not printed twice.
constexpr std::size_t kMostPrinted = 2000;

constexpr std::array<int, 3> kEndings{SIGINT, SIGTERM, SIGHUP};

extern "C" void on_interrupt(int) {
  interrupted = true;
  for (const int ending : kEndings) std::signal(ending, SIG_DFL);  // a second one, of any kind, ends at once
}

void end_on_signals() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  sigemptyset(&action.sa_mask);
  action.sa_flags = 0;  // without SA_RESTART a source that waits for data wakes up
  for (const int ending : kEndings) {
    struct sigaction before {};
    // What the shell has switched off stays so: `nohup waymark run …`.
    if (sigaction(ending, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
    sigaction(ending, &action, nullptr);
  }
}

struct RunOptions {
  std::filesystem::path config;
  std::filesystem::path out;
  std::vector<std::string> overrides;
  std::optional<std::int64_t> seed;
  std::optional<int> threads;
  std::optional<double> until_s;
  std::filesystem::path save;
  std::filesystem::path resume;
  bool allow_outside = false;
  bool quiet = false;
  std::string log_level = "info";
};

std::filesystem::path prepare_output(const RunOptions& options) {
  std::filesystem::path out = options.out.empty() ? std::filesystem::path("out") / options.config.stem() : options.out;
  create_folder(out, "output folder");
  if (!std::filesystem::is_directory(out)) throw Error(fmt::format("{}: is not a folder", out.string()));
  if (access(out.c_str(), W_OK) != 0) throw Error(fmt::format("{}: the output folder is not writable", out.string()));
  return out;
}

/// `printed`: events that were printed when they happened.
void print_report(const RunReport& report, const std::set<std::string>& printed, const RunLog& log) {
  for (const Event& event : report.events) {
    if (!event.is_failure && !printed.contains(event.text))
      log.print(LogLevel::warning, "waymark: at {:.3f} s: {}\n", event.stamp_s, event.text);
  }
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, report.bad_records.size()); ++i) {
    log.print(LogLevel::warning, "waymark: skipped {}: {}\n", report.bad_records[i].place,
              report.bad_records[i].reason);
  }
  if (report.bad_records.size() > kShown)
    log.print(LogLevel::warning, "waymark: … and {} more\n", report.bad_records.size() - kShown);
  for (const std::string& notice : report.notices) log.print(LogLevel::warning, "waymark: note: {}\n", notice);
}

/// Prints the changes of the pose's health.
class HealthChanges {
 public:
  explicit HealthChanges(const RunLog& log) : log_(log) {}
  void look_at(const Snapshot& snapshot) {
    const Health& health = snapshot.health();
    if (health.state == state_ && health.reason == reason_) return;
    state_ = health.state;
    reason_ = health.reason;
    log_.print(LogLevel::debug, "waymark: at {} s: health {}{}{}\n", format_time(snapshot.measurement().stamp),
               to_string(state_), reason_.empty() ? "" : ": ", reason_);
  }

 private:
  const RunLog& log_;
  Health::State state_ = Health::State::ok;
  std::string reason_;
};

/// A running robot is ended by a signal as a matter of course.
int exit_code_of(const host::SessionResult& result, bool is_live) {
  if (!result.log_error.empty()) return kError;
  if (result.report.interrupted && !is_live) return kInterrupted;
  if (!result.started) return kError;
  return result.failures.empty() ? kSuccess : kImpaired;
}

int run(const RunOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  if (options.seed) overrides.push_back(fmt::format("filter.seed={}", *options.seed));
  if (options.threads) overrides.push_back(fmt::format("filter.threads={}", *options.threads));
  const Config yaml = is_flight_record(options.config) ? config_of_flight_record(options.config, overrides)
                                                       : Config::load(options.config, overrides);
  const RunLog log(options.quiet ? std::min(LogLevel::warning, log_level(options.log_level))
                                 : log_level(options.log_level));
  if (options.allow_outside) yaml.permit_outside();
  host::Robot robot = host::Robot::load(yaml, host::plugin_loader(yaml));
  const bool is_live = robot.source->is_live();
  const std::filesystem::path out = prepare_output(options);

  end_on_signals();
  Progress progress;
  host::SessionOptions session_options{.out = out, .until_s = options.until_s, .stop = &interrupted};
  std::set<std::string> printed;
  if (is_live) {
    session_options.on_event = [&](const Event& event) {
      // A run of months has more of them than are worth keeping.
      if (printed.size() < kMostPrinted) printed.insert(event.text);
      log.print(LogLevel::warning, "waymark: at {:.3f} s: {}\n", event.stamp_s, event.text);
    };
  }
  HealthChanges health(log);
  session_options.observer = [&](const Snapshot& snapshot, double share) {
    if (log.shows(LogLevel::info)) progress.update(snapshot, share);
    if (log.shows(LogLevel::debug)) health.look_at(snapshot);
  };
  host::Session session(std::move(robot), std::move(session_options));
  const host::LiveSettings& live = session.robot().live_settings;
  if (!options.resume.empty()) {
    session.resume(options.resume);
  } else if (is_live && live.resumes && !live.checkpoint.empty()) {
    const std::string problem = session.resume_if_possible(out / live.checkpoint);
    if (!problem.empty()) log.print(LogLevel::warning, "waymark: begins anew: {}\n", problem);
  }
  session.play();
  const host::SessionResult result = options.save.empty() ? session.finish() : session.suspend(options.save);
  progress.finish();
  print_report(result.report, printed, log);
  for (const std::string& line : result.replaced) log.print(LogLevel::info, "waymark: {}\n", line);
  log.print(LogLevel::info, "{}{:.1f} s of log in {:.2f} s; results in {}\n",
            result.report.interrupted ? "interrupted: " : "", progress.log_seconds(), progress.wall_seconds(),
            out.string());
  // All that went wrong, in one line and the last one, so that nobody has to look for it.
  if (!result.failures.empty()) log.print(LogLevel::error, "waymark: error: {}\n", fmt::join(result.failures, "; "));
  return exit_code_of(result, is_live);
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Run a robot on its log: trajectory, map, picture and diagnostics");
  command->footer(
      "Example:\n  waymark run config/quickstart.yaml --out out/quickstart --set filter.particles=100 --seed 2\n"
      "  waymark run config/quickstart.yaml --until 60 --save half.ckpt --out out/first\n"
      "  waymark run config/quickstart.yaml --resume half.ckpt --out out/second\n"
      "  waymark run out/robot/flight.mcap --out out/replay\n\n"
      "Exit code: 0 all well; 1 error; 2 wrong command line; 3 ended, but a plugin was taken out of service or the "
      "pose was lost to the end; 130 interrupted (outputs are written; a live run ends with 0).");
  command
      ->add_option("config", options->config,
                   "the YAML that describes robot, log and outputs; or a flight record (.mcap), which is replayed")
      ->required();
  command->add_option("--out", options->out, "folder for the results (default: out/<name of the YAML>)");
  command->add_option("--set", options->overrides,
                      "key=value: overrides a key of the YAML, e.g. sensors.gps.sigma_m=0.1");
  command->add_option("--seed", options->seed, "the same as --set filter.seed=N")->check(non_negative_number());
  command->add_option("--threads", options->threads, "the same as --set filter.threads=N; results do not depend on it");
  command->add_option("--until", options->until_s, "stop reading this many seconds after the first arrival of the log")
      ->check(non_negative_number());
  command->add_option("--save", options->save, "write a checkpoint at the end of what was read, to go on from");
  command->add_option(
      "--resume", options->resume,
      "go on from a checkpoint of the same configuration and log; sinks, plugin_path and filter.threads "
      "may differ");
  command->add_flag("--allow-outside", options->allow_outside, "files named in the YAML may lie outside of the folder");
  command->add_flag("--quiet", options->quiet, "no progress and no summary; warnings and errors stay");
  command
      ->add_option("--log-level", options->log_level,
                   "what is printed: error; warning: events and skipped data, too; info (default): progress and "
                   "summary, too; debug: changes of the health, too")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}));
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace waymark::command
