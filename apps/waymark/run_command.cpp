// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "assembly.hpp"
#include "command_line.hpp"
#include "commands.hpp"
#include "progress.hpp"
#include "waymark/host/fusion.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark {

namespace {

std::atomic<bool> interrupted{false};

extern "C" void on_interrupt(int) {
  interrupted = true;
  std::signal(SIGINT, SIG_DFL);  // a second one, of either kind, ends at once
  std::signal(SIGTERM, SIG_DFL);
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
  bool quiet = false;
};

std::filesystem::path prepare_output(const RunOptions& options) {
  std::filesystem::path out = options.out.empty() ? std::filesystem::path("out") / options.config.stem() : options.out;
  create_folder(out, "output folder");
  if (!std::filesystem::is_directory(out)) throw Error(fmt::format("{}: is not a folder", out.string()));
  if (access(out.c_str(), W_OK) != 0) throw Error(fmt::format("{}: the output folder is not writable", out.string()));
  return out;
}

/// The sinks of a run: one that fails is left out from then on, the others go on.
class Sinks {
 public:
  Sinks(std::vector<SinkSlot> slots, const RunInfo& info) : slots_(std::move(slots)) {
    call([&](Sink& sink) { sink.start(info); });
  }
  void arrived(const Measurement& measurement) {
    call([&](Sink& sink) { sink.arrived(measurement); });
  }
  void write(const Snapshot& snapshot) {
    call([&](Sink& sink) { sink.write(snapshot); });
  }
  void finish(const Snapshot* last, const RunReport& report) {
    call([&](Sink& sink) { sink.finish(last, report); });
  }
  const std::vector<std::string>& failures() const { return failures_; }

 private:
  template <class Call>
  void call(const Call& what) {
    for (SinkSlot& slot : slots_) {
      if (!slot.sink) continue;
      std::string why;
      try {
        what(*slot.sink);
        continue;
      } catch (const std::exception& error) {
        why = error.what();
      } catch (...) {
        why = "unknown exception";
      }
      failures_.push_back(fmt::format("sink {}: taken out of service: {}", slot.plugin, why));
      slot.sink = nullptr;
    }
  }

  std::vector<SinkSlot> slots_;
  std::vector<std::string> failures_;
};

/// The log up to `until` seconds after its first arrival.
class Log {
 public:
  Log(Assembly& robot, std::optional<double> until_s) : robot_(robot), until_s_(until_s) {}

  std::optional<Measurement> next() {
    while (auto measurement = next_of_source()) {
      if (!first_) first_ = measurement->arrival;
      if (until_s_ && to_seconds(measurement->arrival - *first_) > *until_s_) return std::nullopt;
      if (robot_.address(*measurement)) return measurement;
    }
    return std::nullopt;
  }

 private:
  /// Whatever a source throws ends the log, not the run: what came before is worth its results.
  std::optional<Measurement> next_of_source() {
    try {
      return robot_.source->next();
    } catch (const Error&) {
      throw;
    } catch (const std::exception& error) {
      throw Error(fmt::format("the source failed: {}", error.what()));
    } catch (...) {
      throw Error("the source failed: unknown exception");
    }
  }

  Assembly& robot_;
  std::optional<double> until_s_;
  std::optional<Time> first_;
};

void save_checkpoint(const Fusion& fusion, const std::filesystem::path& file) {
  std::ostringstream bytes;
  OutArchive archive(bytes);
  fusion.save(archive);
  write_file(file, bytes.str());
}

void resume_checkpoint(Fusion& fusion, const std::filesystem::path& file, Log& log) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Error(fmt::format("{}: the checkpoint cannot be read", file.string()));
  InArchive archive(stream);
  try {
    fusion.resume(archive, [&] { return log.next(); });
  } catch (const DataError& error) {
    throw Error(fmt::format("{}: {}", file.string(), error.what()));
  }
}

void print_report(const RunReport& report) {
  for (const Event& event : report.events) {
    if (!event.is_failure) say("waymark: at {:.3f} s: {}\n", event.stamp_s, event.text);
  }
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, report.bad_records.size()); ++i) {
    say("waymark: skipped {}: {}\n", report.bad_records[i].place, report.bad_records[i].reason);
  }
  if (report.bad_records.size() > kShown) say("waymark: … and {} more\n", report.bad_records.size() - kShown);
  for (const std::string& notice : report.notices) say("waymark: note: {}\n", notice);
}

int run(const RunOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  if (options.seed) overrides.push_back(fmt::format("filter.seed={}", *options.seed));
  if (options.threads) overrides.push_back(fmt::format("filter.threads={}", *options.threads));
  Assembly robot = Assembly::load(options.config, overrides);
  const std::filesystem::path out = prepare_output(options);
  const std::string effective = robot.yaml.effective();
  write_file(out / "config.yaml", effective);

  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  Sinks sinks(std::move(robot.sinks), {out, &robot.rig, robot.source->reference(), effective});
  Progress progress;
  Fusion fusion(robot.settings, robot.sensors, robot.maps, [&](const Snapshot& snapshot) {
    sinks.write(snapshot);
    if (!options.quiet) progress.update(snapshot, robot.source->progress());
  });

  Log log(robot, options.until_s);
  if (!options.resume.empty()) resume_checkpoint(fusion, options.resume, log);
  std::string data_error;
  try {
    while (!interrupted) {
      std::optional<Measurement> measurement = log.next();
      if (!measurement) break;
      sinks.arrived(*measurement);
      fusion.add(std::move(*measurement));
    }
  } catch (const Error& error) {
    data_error = error.what();  // what was read until now is still worth its results
  }
  if (options.save.empty()) {
    fusion.finish();
  } else {
    save_checkpoint(fusion, options.save);  // what waits is not committed: the next run reads it again
  }
  progress.finish();

  RunReport report = fusion.report();
  report.bad_records = robot.source->bad_records();
  report.notices = robot.source->notices();
  report.interrupted = interrupted;
  bool shown = false;
  fusion.show_last([&](const Snapshot& last) {
    shown = true;
    sinks.finish(&last, report);
  });
  if (!shown) sinks.finish(nullptr, report);
  print_report(report);

  if (!options.quiet) {
    say("{}{:.1f} s of log in {:.2f} s; results in {}\n", interrupted ? "interrupted: " : "", progress.log_seconds(),
        progress.wall_seconds(), out.string());
  }
  // All that went wrong, in one line and the last one, so that nobody has to look for it.
  std::vector<std::string> failures;
  if (!data_error.empty()) failures.push_back(data_error);
  for (const Event& event : report.events) {
    const bool no_result = !fusion.started() && data_error.empty() && !interrupted && &event == &report.events.back();
    if (event.is_failure || no_result) failures.push_back(fmt::format("at {:.3f} s: {}", event.stamp_s, event.text));
  }
  failures.insert(failures.end(), sinks.failures().begin(), sinks.failures().end());
  if (!failures.empty()) say("waymark: error: {}\n", fmt::join(failures, "; "));
  if (!data_error.empty()) return kError;
  if (interrupted) return kInterrupted;
  if (!fusion.started()) return kError;
  return failures.empty() ? kSuccess : kImpaired;
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Run a robot on its log: trajectory, map, picture and diagnostics");
  command->footer(
      "Example:\n  waymark run config/quickstart.yaml --out out/quickstart --set filter.particles=100 --seed 2\n"
      "  waymark run config/quickstart.yaml --until 60 --save half.ckpt --out out/first\n"
      "  waymark run config/quickstart.yaml --resume half.ckpt --out out/second\n\n"
      "Exit code: 0 all well; 1 error; 2 wrong command line; 3 ended, but a plugin was taken out of service; 130 "
      "interrupted (outputs are written).");
  command->add_option("config", options->config, "the YAML that describes robot, log and outputs")->required();
  command->add_option("--out", options->out, "folder for the results (default: out/<name of the YAML>)");
  command->add_option("--set", options->overrides,
                      "key=value: overrides a key of the YAML, e.g. sensors.gps.sigma_m=0.1");
  command->add_option("--seed", options->seed, "the same as --set filter.seed=N")->check(non_negative_number());
  command->add_option("--threads", options->threads, "the same as --set filter.threads=N; results do not depend on it");
  command->add_option("--until", options->until_s, "stop reading this many seconds after the first arrival of the log")
      ->check(non_negative_number());
  command->add_option("--save", options->save, "write a checkpoint at the end of what was read, to go on from");
  command->add_option("--resume", options->resume, "go on from a checkpoint of the same configuration and log");
  command->add_flag("--quiet", options->quiet, "no progress and no summary; warnings and errors stay");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace waymark
