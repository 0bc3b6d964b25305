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
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/folded_events.hpp"
#include "apps/waymark/command/heap_trim.hpp"
#include "apps/waymark/command/progress.hpp"
#include "apps/waymark/command/run_log.hpp"
#include "apps/waymark/command/sensor_table.hpp"
#include "waymark/host/flight_record.hpp"
#include "waymark/host/session.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::command {

namespace {

std::atomic<bool> interrupted{false};

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

/// A larger share of scans that do not fit the map is a warning.
constexpr double kFewFailedMatches = 0.1;

void print_matches(const std::vector<MatchReport>& maps, const RunLog& log) {
  for (const MatchReport& map : maps) {
    const std::uint64_t scans = map.matches + map.failed;
    if (scans == 0) continue;
    const double share = static_cast<double>(map.failed) / static_cast<double>(scans);
    log.print(share > kFewFailedMatches ? LogLevel::warning : LogLevel::info,
              "waymark: map {}: {} of {} scans did not fit ({:.0f} %), {} needed a search around the predicted pose\n",
              map.map, map.failed, scans, 100.0 * share, map.searches);
  }
}

/// `printed`: what was printed when it happened.
void print_report(const RunReport& report, const RepeatedEvents& printed, const RunLog& log) {
  std::vector<Event> events;
  // Failures come in the last line.
  std::ranges::copy_if(report.events, std::back_inserter(events), [](const Event& e) { return !e.is_failure; });
  for (const FoldedEvents& folded : fold(events)) {
    if (folded.count == 1 && printed.has_shown(folded.first)) continue;
    for (const std::string& line : folded.lines()) log.print(LogLevel::warning, "waymark: {}\n", line);
  }
  print_matches(report.matches, log);
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
  if (!result.failures.empty()) return kImpaired;
  return result.lost.empty() || is_live ? kSuccess : kLost;
}

int run(const RunOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  if (options.seed) overrides.push_back(fmt::format("filter.seed={}", *options.seed));
  if (options.threads) overrides.push_back(fmt::format("filter.threads={}", *options.threads));
  const host::RecordedRun given =
      host::is_flight_record(options.config)
          ? host::recorded_run(options.config, overrides)
          : host::RecordedRun{Config::load(options.config, overrides), options.config.stem()};
  const Config& yaml = given.config;
  const RunLog log(options.quiet ? std::min(LogLevel::warning, log_level(options.log_level))
                                 : log_level(options.log_level));
  if (options.allow_outside) yaml.permit_outside();
  host::Robot robot = host::Robot::load(yaml, host::plugin_loader(yaml));
  const bool is_live = robot.source->is_live();
  const std::filesystem::path out = prepare_output(options);

  end_on_signals();
  Progress progress;
  host::SessionOptions session_options{
      .out = out, .name = given.name, .until_s = options.until_s, .stop = &interrupted};
  RepeatedEvents repeated;
  if (is_live) {
    session_options.on_event = [&](const Event& event) {
      std::uint64_t count = 0;
      if (!repeated.shows(event, count)) return;
      log.print(LogLevel::warning, "waymark: at {} s: {}{}\n", format_time(event.stamp, 3), event.text,
                count > 3 ? fmt::format(" (the {}th time)", count) : "");
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
  std::optional<HeapTrim> heap_trim;
  if (is_live) heap_trim.emplace();
  session.play();
  heap_trim.reset();
  const host::SessionResult result = options.save.empty() ? session.finish() : session.suspend(options.save);
  progress.finish();
  print_report(result.report, repeated, log);
  for (const std::string& line : result.replaced) log.print(LogLevel::info, "waymark: {}\n", line);
  log.print(LogLevel::info, "{}{:.1f} s of log in {:.2f} s; results in {}\n",
            result.report.interrupted ? "interrupted: " : "", progress.log_seconds(), progress.wall_seconds(),
            out.string());
  for (const std::string& line : sensor_table(result.report)) log.print(LogLevel::info, "{}\n", line);
  // All that went wrong, in one line and the last one, so that nobody has to look for it.
  std::vector<std::string> problems = result.failures;
  if (!result.lost.empty()) problems.push_back(result.lost);
  if (!problems.empty()) log.print(LogLevel::error, "waymark: error: {}\n", fmt::join(problems, "; "));
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
      "pose was lost to the end; 4 ended, but the pose was lost for a larger share of the run than "
      "health.max_lost_share; "
      "130 interrupted (outputs are written; a live run ends with 0).");
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
