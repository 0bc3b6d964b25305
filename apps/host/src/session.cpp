// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <sstream>
#include <utility>

#include "checkpoint_file.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::host {

namespace {

RunInfo info_of(const Robot& robot, const std::filesystem::path& out) {
  return {out, &robot.rig, robot.source ? robot.source->reference() : nullptr, robot.yaml.effective()};
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
      results_(std::move(robot_.sinks), info_of(robot_, options_.out), lock_ != nullptr),
      fusion_(robot_.fusion([this](const Snapshot& snapshot) {
        results_.write(snapshot);
        if (options_.observer) options_.observer(snapshot, robot_.source ? robot_.source->progress() : -1.0);
      })),
      log_(std::make_unique<LogIdentity>()) {}

Session::~Session() = default;

void Session::resume(const std::filesystem::path& checkpoint) {
  CheckpointIdentity identity;
  std::istringstream stream(read_checkpoint(checkpoint, identity));
  const auto fail = [&](std::string_view why) { throw Error(fmt::format("{}: {}", checkpoint.string(), why)); };
  if (identity.config != identity_of(robot_.yaml.effective()))
    fail("is of a run with another configuration; only sinks, plugin_path and filter.threads may differ");
  InArchive archive(stream);
  try {
    fusion_->resume(archive, [this] { return next(); });
  } catch (const DataError& error) {
    fail(error.what());
  }
  if (identity.log != log_->hash()) fail("is of a run with another log");
}

void Session::play() {
  try {
    while (options_.stop == nullptr || !*options_.stop) {
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
    std::ostringstream state;
    OutArchive archive(state);
    fusion_->save(archive);
    write_checkpoint(checkpoint, {identity_of(robot_.yaml.effective()), log_->hash()}, state.str());
  } catch (const std::exception& error) {
    checkpoint_error_ = fmt::format("the checkpoint is not written: {}", error.what());
  }
  return conclude();
}

std::optional<Measurement> Session::next() {
  if (!robot_.source) throw Error("the robot has no source to read measurements from");
  while (std::optional<Measurement> measurement = next_of(*robot_.source)) {
    if (!first_arrival_) first_arrival_ = measurement->arrival;
    if (options_.until_s && to_seconds(measurement->arrival - *first_arrival_) > *options_.until_s) return std::nullopt;
    if (!robot_.assign(*measurement)) continue;
    log_->add(*measurement);
    return measurement;
  }
  return std::nullopt;
}

SessionResult Session::conclude() {
  SessionResult result;
  result.started = fusion_->started();
  result.log_error = log_error_;
  result.report = fusion_->report();
  if (robot_.source) {
    result.report.bad_records = robot_.source->bad_records();
    result.report.notices = robot_.settings.notices;
    std::ranges::copy(robot_.source->notices(), std::back_inserter(result.report.notices));
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
  return result;
}

}  // namespace waymark::host
