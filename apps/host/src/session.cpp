// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <utility>

#include "checkpoint_file.hpp"
#include "commands.hpp"
#include "live_run.hpp"
#include "plugins/shared/map_formats/write_maps.hpp"
#include "portable_config.hpp"
#include "status_line.hpp"
#include "verdict.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/command.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::host {

namespace {

/// Events of sources, queue and sinks that are kept for the report.
constexpr std::ptrdiff_t kMostEvents = 2000;

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

/// With the report, if the run owns its folder.
std::vector<SinkSlot> sinks_of(Robot& robot, bool owns_folder) {
  std::vector<SinkSlot> sinks = std::move(robot.sinks);
  if (robot.report && owns_folder) sinks.push_back({"report", std::move(robot.report)});
  return sinks;
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

}  // namespace

Session::Session(Robot robot, SessionOptions options)
    : robot_(std::move(robot)),
      options_(std::move(options)),
      lock_(options_.owns_folder && !options_.out.empty() ? std::make_unique<FolderLock>(options_.out) : nullptr),
      results_(sinks_of(robot_, lock_ != nullptr),
               RunInfo{options_.out, &robot_.rig, reference_of(robot_, reference_error_), robot_.yaml.effective(),
                       options_.name.empty() ? robot_.yaml.file().stem().string() : options_.name},
               lock_ ? portable_config(robot_.yaml) : std::string()),
      fusion_(make_fusion(robot_)),
      diagnosis_(robot_.is_diagnosed ? std::make_unique<Diagnosis>(robot_) : nullptr),
      log_(std::make_unique<LogIdentity>()),
      config_identity_(identity_of(robot_.yaml.effective())) {
  if (robot_.live_input)
    live_ = std::make_unique<LiveRun>(robot_.live_input, robot_.live_clock, robot_, results_, options_.stop,
                                      [this] { take_new_events(); });
}

Session::~Session() = default;

std::unique_ptr<Fusion> Session::make_fusion(const Robot& robot) {
  return robot.fusion([this](const Snapshot& snapshot) {
    results_.write(snapshot);
    if (live_) live_->processed(snapshot);
    if (options_.observer) options_.observer(snapshot, robot_.source ? robot_.source->progress() : -1.0);
  });
}

/// The state of a checkpoint of this configuration.
std::string Session::read(const std::filesystem::path& checkpoint, std::uint64_t& log_identity) const {
  CheckpointIdentity identity;
  std::string state = read_checkpoint(checkpoint, identity);
  if (identity.config != config_identity_) {
    throw Error(
        fmt::format("{}: is of a run with another configuration; only sinks, plugin_path and filter.threads may differ",
                    checkpoint.string()));
  }
  log_identity = identity.log;
  return state;
}

void Session::load(const std::filesystem::path& checkpoint, std::string state, std::uint64_t log_identity) {
  const auto fail = [&](std::string_view why) { throw Error(fmt::format("{}: {}", checkpoint.string(), why)); };
  std::istringstream stream(std::move(state));
  InArchive archive(stream);
  try {
    if (archive.section("session", 1) < 1) throw DataError("the checkpoint has an older version");
    bool is_live = false;
    std::uint64_t next_sequence = 0;
    archive(is_live, retunings_, next_sequence);
    if (is_live != (live_ != nullptr))
      fail(is_live ? "is of a running robot, and this run is of a log" : "is of a log, and this robot is running");
    for (const std::string& key_and_value : retunings_) robot_.adopt(robot_.retuned(key_and_value));
    if (!retunings_.empty()) fusion_ = make_fusion(robot_);
    if (live_) {
      live_->number_from(next_sequence);
      for (Measurement& waiting : fusion_->resume_with_measurements(archive)) add(std::move(waiting));
      return;
    }
    fusion_->resume(archive, [this] { return next(); });
  } catch (const DataError& error) {
    fail(error.what());
  }
  if (log_identity != log_->hash()) fail("is of a run with another log");
}

void Session::resume(const std::filesystem::path& checkpoint) {
  std::uint64_t log_identity = 0;
  std::string state = read(checkpoint, log_identity);
  load(checkpoint, std::move(state), log_identity);
}

std::string Session::resume_if_possible(const std::filesystem::path& checkpoint) {
  const Robot untuned = robot_;
  try {
    resume(checkpoint);
    return {};
  } catch (const std::exception& error) {
    // Half of the state may be loaded.
    robot_.adopt(Robot(untuned));
    retunings_.clear();
    fusion_ = make_fusion(robot_);
    return error.what();
  }
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
  if (diagnosis_) diagnose(measurement);
  last_arrival_ = measurement.arrival;
  fusion_->add(std::move(measurement));
  if (live_) follow_live();
}

/// A diagnosis that fails does not end the run: it is switched off.
void Session::diagnose(const Measurement& measurement) {
  try {
    diagnosis_->arrived(measurement);
    note_findings();
  } catch (const std::exception& error) {
    const std::string problem = fmt::format("the diagnosis is switched off: {}", error.what());
    if (live_) live_->note(problem);
    diagnosis_ = nullptr;
  }
}

std::vector<Finding> Session::findings() const { return diagnosis_ ? diagnosis_->findings() : std::vector<Finding>{}; }

/// Of a running robot, when they become certain; those of a log are events of its report.
void Session::note_findings() {
  if (!live_) return;
  for (const Finding& finding : diagnosis_->take_new()) live_->note("diagnosis: " + describe(finding));
}

void Session::add_findings(SessionResult& result) const {
  result.report.findings = findings();
  if (live_) return;  // they are events already
  std::vector<Event>& events = result.report.events;
  for (const Finding& finding : result.report.findings) {
    const auto later = std::ranges::find_if(events, [&](const Event& e) { return e.stamp > finding.stamp; });
    // The last event names the cause of a missing start.
    const auto place = result.started || events.empty() ? later : std::min(later, events.end() - 1);
    events.insert(place, {"diagnosis: " + describe(finding), finding.stamp, false});
  }
}

void Session::follow_live() {
  for (const auto& [sensor, count] : live_->added(*fusion_)) {
    // As a command, so that a replay has the same health at the same place.
    fusion_->note_dropped(sensor);
    results_.commanded(last_arrival_, dropped_command(robot_.sensors[sensor].name, count));
  }
  for (const auto& [sensor, gap] : live_->take_gaps()) {
    note_missing(sensor, gap, last_arrival_);
    results_.commanded(last_arrival_, missing_command(robot_.sensors[sensor].name, gap));
  }
  write_live_checkpoint_if_due();
  take_new_events();
}

/// Found by a running robot, and repeated by the replay of its record at the same place, with the same event.
void Session::note_missing(std::uint32_t sensor, const Gap& gap, Time arrival) {
  fusion_->note_missing(sensor);
  keep({fmt::format("{}: {}", robot_.sensors[sensor].name, describe(gap)), arrival, false});
}

void Session::write_live_checkpoint_if_due() {
  if (!live_->checkpoint_is_due() || !fusion_->has_pose()) return;
  try {
    write_live_checkpoint();
    if (!std::exchange(checkpoint_problem_, {}).empty()) live_->note("checkpoints are written again");
  } catch (const std::exception& error) {
    // Once, however long a disk is full.
    const std::string problem = fmt::format("the checkpoint is not written: {}", error.what());
    if (std::exchange(checkpoint_problem_, problem) != problem) live_->note(problem);
  }
}

/// A peer that connects and goes, and a robot that runs for months, must not fill the memory.
void Session::take_new_events() {
  for (Event& event : live_->take_events()) keep(std::move(event));
  // The filter keeps its own for the report.
  for (const Event& event : fusion_->take_new_events()) {
    if (options_.on_event) options_.on_event(event);
  }
}

void Session::keep(Event event) {
  if (options_.on_event && live_) options_.on_event(event);
  if (std::ssize(live_events_) >= kMostEvents) {
    live_events_.erase(live_events_.begin() + kMostEvents / 2);
    ++live_events_left_out_;
  }
  live_events_.push_back(std::move(event));
}

/// A command of a running robot, or its record.
void Session::obey(const Measurement& command) {
  const std::string& text = command.as<Command>().text;
  CommandOutputs outputs;
  if (live_) {
    outputs = {[this] { return save_maps(); },
               [this] { return write_live_checkpoint(); },
               [this] { return status_line(*fusion_, robot_, live_->report(), live_->silence()); },
               [this] { stopped_ = true; },
               {},
               {}};
  }
  outputs.retune = [this](const std::string& key_and_value) { retune(key_and_value); };
  outputs.note_missing = [&](std::uint32_t sensor, const Gap& gap) { note_missing(sensor, gap, command.arrival); };
  const std::string answer = execute(text, *fusion_, robot_, outputs, live_ == nullptr);
  const bool has_changed_filter = answer.starts_with("ok") && steers(text);
  if (has_changed_filter) results_.commanded(command.arrival, text);
  if (!live_) return;
  // A command may come from a source that does not see the answer.
  if (steers(text)) live_->note(fmt::format("command: {}{}", text, has_changed_filter ? "" : ": " + answer));
  live_->reply(command.sequence, answer);
  take_new_events();
}

/// The filter goes on in another host with the new settings, from a checkpoint in memory.
void Session::retune(const std::string& key_and_value) {
  std::stringstream state;
  OutArchive out(state);
  fusion_->save_with_measurements(out);
  Robot tuned = robot_.retuned(key_and_value);
  std::unique_ptr<Fusion> fusion = make_fusion(tuned);
  InArchive in(state);
  fusion->resume_with_measurements(in);
  if (live_) live_->replaced(*fusion);  // nothing uses the older one then
  fusion_ = std::move(fusion);
  robot_.adopt(std::move(tuned));
  retunings_.push_back(key_and_value);
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
    map_formats::write_maps(last, out, FileStems::of_results(), Belongs::to_nobody);
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
  archive.section("session", 1);
  archive(live_ != nullptr, retunings_, live_ ? live_->next_sequence() : std::uint64_t{0});
  if (live_) {
    fusion_->save_with_measurements(archive, live_->waiting_measurements());
  } else {
    fusion_->save(archive);
  }
  write_checkpoint(checkpoint, {config_identity_, log_->hash()}, state.str());
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
  if (diagnosis_) diagnosis_->finish();
  if (live_) {
    if (diagnosis_) note_findings();
    live_->end();
    take_new_events();
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
  }
  if (live_events_left_out_ > 0) {
    result.report.notices.push_back(
        fmt::format("{} events of the running robot are left out: the first and the last {} are kept",
                    live_events_left_out_, kMostEvents / 2));
  }
  if (!live_events_.empty()) {
    std::vector<Event>& events = result.report.events;
    // The event that the filter never started stays the last one, whatever its time.
    const std::ptrdiff_t kept = result.started || events.empty() ? 0 : 1;
    events.insert(events.end() - kept, live_events_.begin(), live_events_.end());
    std::ranges::stable_sort(events.begin(), events.end() - kept, {}, &Event::stamp);
  }
  if (diagnosis_) add_findings(result);
  // A running robot is ended so as a matter of course.
  result.report.interrupted = !live_ && options_.stop != nullptr && *options_.stop;
  bool reported = false;
  fusion_->visit_last([&](const Snapshot& last) {
    reported = true;
    result.report.matches = matches_of(last);
    results_.finish(&last, result.report);
  });
  if (!reported) results_.finish(nullptr, result.report);
  result.failures = failures_of(result, results_.failures());
  result.lost = lost_of(result.report.health, robot_.settings.health.max_lost_share);
  result.replaced = results_.replaced();
  if (!checkpoint_error_.empty()) result.failures.push_back(checkpoint_error_);
  if (!reference_error_.empty()) result.failures.push_back("no reference: " + reference_error_);
  return result;
}

}  // namespace waymark::host
