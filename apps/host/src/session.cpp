// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <sstream>
#include <utility>

#include "checkpoint_file.hpp"
#include "commands.hpp"
#include "live_run.hpp"
#include "status_line.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/command.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::host {

namespace {

/// The truth is for pictures and scores: without it the run goes on, and `problem` says why.
std::shared_ptr<const Reference> reference_of(const Robot& robot, std::string& problem) {
  if (!robot.source) return nullptr;
  try {
    return robot.source->reference();
  } catch (const Error& error) {
    problem = error.what();
    return nullptr;
  }
}

/// Converts every exception of a source to Error: it ends the log, not the program.
std::optional<Measurement> next_of(Source& source) {
  try {
    return source.next();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(fmt::format("the source failed: {}", error.what()));
  } catch (...) {
    throw Error("the source failed: unknown exception");
  }
}

std::vector<std::string> failures_of(const SessionResult& result, const std::vector<std::string>& of_sinks) {
  std::vector<std::string> failures;
  if (!result.log_error.empty()) failures.push_back(result.log_error);
  // The last event names the cause of a missing start, unless the log ended early.
  const bool names_cause = !result.started && result.log_error.empty() && !result.report.interrupted;
  for (const Event& event : result.report.events) {
    if (event.is_failure || (names_cause && &event == &result.report.events.back()))
      failures.push_back(fmt::format("at {:.3f} s: {}", event.stamp_s, event.text));
  }
  failures.insert(failures.end(), of_sinks.begin(), of_sinks.end());
  return failures;
}

}  // namespace

Session::Session(Robot robot, SessionOptions options)
    : robot_(std::move(robot)),
      options_(std::move(options)),
      lock_(options_.owns_folder && !options_.out.empty() ? std::make_unique<FolderLock>(options_.out) : nullptr),
      results_(std::move(robot_.sinks),
               RunInfo{options_.out, &robot_.rig, reference_of(robot_, reference_error_), robot_.yaml.effective()},
               lock_ != nullptr),
      fusion_(robot_.fusion([this](const Snapshot& snapshot) {
        results_.write(snapshot);
        if (live_) live_->processed(snapshot);
        if (options_.observer) options_.observer(snapshot, robot_.source ? robot_.source->progress() : -1.0);
      })),
      log_(std::make_unique<LogIdentity>()) {
  if (robot_.live_input)
    live_ = std::make_unique<LiveRun>(robot_.live_input, robot_.live_clock, robot_, results_, options_.stop);
}

Session::~Session() = default;

void Session::resume(const std::filesystem::path& checkpoint) {
  CheckpointIdentity identity;
  std::istringstream stream(read_checkpoint(checkpoint, identity));
  const auto fail = [&](std::string_view why) { throw Error(fmt::format("{}: {}", checkpoint.string(), why)); };
  if (identity.config != identity_of(robot_.yaml.effective()))
    fail("is of a run with another configuration; only sinks, plugin_path and filter.threads may differ");
  InArchive archive(stream);
  try {
    if (live_) return fusion_->resume_with_measurements(archive);
    fusion_->resume(archive, [this] { return next(); });
  } catch (const DataError& error) {
    fail(error.what());
  }
  if (identity.log != log_->hash()) fail("is of a run with another log");
}

void Session::play() {
  try {
    while (!stopped_ && (options_.stop == nullptr || !*options_.stop)) {
      std::optional<Measurement> measurement = next();
      if (!measurement) break;
      add(std::move(*measurement));
    }
  } catch (const Error& error) {
    log_error_ = error.what();
  } catch (const std::exception& error) {
    log_error_ = fmt::format("the run ended early: {}", error.what());
  }
}

void Session::add(Measurement measurement) {
  results_.arrived(measurement);
  fusion_->add(std::move(measurement));
  if (live_) follow_live();
}

void Session::follow_live() {
  live_->added(*fusion_);
  if (live_->checkpoint_is_due()) {
    try {
      write_live_checkpoint();
    } catch (const std::exception& error) {
      live_->note(fmt::format("the checkpoint is not written: {}", error.what()));
    }
  }
  take_live_events();
}

void Session::take_live_events() {
  for (Event& event : live_->take_events()) {
    if (options_.on_event) options_.on_event(event);
    live_events_.push_back(std::move(event));
  }
}

/// A command of a running robot, or its record.
void Session::obey(const Measurement& command) {
  const std::string& text = command.as<Command>().text;
  CommandOutputs outputs;
  if (live_) {
    outputs = {[this] { return save_maps(); }, [this] { return write_live_checkpoint(); },
               [this] { return status_line(*fusion_, robot_, live_->report()); }, [this] { stopped_ = true; }};
  }
  const std::string answer = execute(text, *fusion_, robot_, outputs);
  const bool has_changed_filter = answer.starts_with("ok") && steers(text);
  if (has_changed_filter) results_.commanded(command.arrival, text);
  if (!live_) return;
  if (has_changed_filter) live_->note(fmt::format("command: {}", text));
  live_->reply(command.sequence, answer);
  take_live_events();
}

std::string Session::write_live_checkpoint() {
  const std::filesystem::path file =
      options_.out / (robot_.live_settings.checkpoint.empty() ? "live.ckpt" : robot_.live_settings.checkpoint);
  write(file);
  return file.string();
}

std::string Session::save_maps() {
  std::string folder;
  fusion_->visit_last([&](const Snapshot& last) {
    if (!last.started()) return;
    const std::filesystem::path out = options_.out / "maps";
    create_folder(out, "folder of the maps");
    FileStems stems({});
    for (const MapDescription& map : last.best_maps(MapDetail::with_files)) {
      const std::string stem = stems.of(map.module);
      for (const MapFile& file : map.files) write_file(out / (stem + file.extension), file.content);
    }
    folder = out.string();
  });
  if (folder.empty()) throw Error("the filter has not started");
  return folder;
}

SessionResult Session::finish() {
  try {
    fusion_->finish();
  } catch (const std::exception& error) {
    if (log_error_.empty()) log_error_ = fmt::format("the run ended early: {}", error.what());
  }
  return conclude();
}

SessionResult Session::suspend(const std::filesystem::path& checkpoint) {
  try {
    write(checkpoint);
  } catch (const std::exception& error) {
    checkpoint_error_ = fmt::format("the checkpoint is not written: {}", error.what());
  }
  return conclude();
}

void Session::write(const std::filesystem::path& checkpoint) const {
  std::ostringstream state;
  OutArchive archive(state);
  if (live_) {
    fusion_->save_with_measurements(archive);
  } else {
    fusion_->save(archive);
  }
  write_checkpoint(checkpoint, {identity_of(robot_.yaml.effective()), log_->hash()}, state.str());
}

std::optional<Measurement> Session::next() {
  if (!robot_.source) throw Error("the robot has no source to read measurements from");
  while (std::optional<Measurement> measurement = next_of(*robot_.source)) {
    if (is_stamp(measurement->arrival)) {
      if (!first_arrival_) first_arrival_ = measurement->arrival;
      const double passed_s = to_seconds(measurement->arrival - *first_arrival_);
      if (options_.until_s && passed_s > *options_.until_s) return std::nullopt;
    }
    if (robot_.is_command(*measurement)) {
      obey(*measurement);
      if (stopped_) return std::nullopt;
      continue;
    }
    if (!robot_.assign(*measurement)) continue;
    log_->add(*measurement);
    return measurement;
  }
  return std::nullopt;
}

SessionResult Session::conclude() {
  if (live_) {
    live_->end();
    take_live_events();
  }
  SessionResult result;
  result.started = fusion_->started();
  result.log_error = log_error_;
  result.report = fusion_->report();
  if (robot_.source) {
    result.report.bad_records = robot_.source->bad_records();
    result.report.notices = robot_.settings.notices;
    std::ranges::copy(robot_.source->notices(), std::back_inserter(result.report.notices));
  }
  if (live_) {
    result.report.live = live_->report();
    result.report.events.insert(result.report.events.end(), live_events_.begin(), live_events_.end());
    std::ranges::stable_sort(result.report.events, {}, &Event::stamp_s);
  }
  result.report.interrupted = options_.stop != nullptr && *options_.stop;
  bool reported = false;
  fusion_->visit_last([&](const Snapshot& last) {
    reported = true;
    results_.finish(&last, result.report);
  });
  if (!reported) results_.finish(nullptr, result.report);
  result.failures = failures_of(result, results_.failures());
  if (!checkpoint_error_.empty()) result.failures.push_back(checkpoint_error_);
  if (!reference_error_.empty()) result.failures.push_back("no reference: " + reference_error_);
  return result;
}

}  // namespace waymark::host
