// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/results.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "run_folder.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/io/written_files.hpp"

namespace waymark::host {

namespace {

/// Its name until the results are complete.
std::string new_config_name() { return fmt::format("{}.new", kEffectiveConfigFile); }

}  // namespace

Results::Results(std::vector<SinkSlot> sinks, const RunInfo& info, const std::string& config_file)
    : info_(info), sinks_(std::move(sinks)) {
  if (!config_file.empty()) {
    // Before any sink opens a file: a full disk then leaves older results as they are.
    write_file(info_.out_dir / new_config_name(), config_file, Belongs::to_nobody);
    folder_ = std::make_unique<RunFolder>(info_.out_dir);
    new_config_ = info_.out_dir / new_config_name();
  }
  for_each([&](Sink& sink) { sink.start(info_); });
}

Results::~Results() {
  std::error_code ignored;
  if (!new_config_.empty()) std::filesystem::remove(new_config_, ignored);
}

void Results::arrived(const Measurement& measurement) {
  for_each([&](Sink& sink) { sink.arrived(measurement); });
}

void Results::dropped(const Measurement& measurement) {
  for_each([&](Sink& sink) { sink.dropped(measurement); });
}

void Results::commanded(Time arrival, std::string_view command) {
  for_each([&](Sink& sink) { sink.commanded(arrival, command); });
}

void Results::front(const Belief& belief) {
  for_each([&](Sink& sink) { sink.front(belief); });
}

std::vector<std::string> Results::take_events() {
  std::vector<std::string> all;
  for_each([&](Sink& sink) { std::ranges::move(sink.take_events(), std::back_inserter(all)); });
  return all;
}

std::vector<std::string> Results::failures() const {
  const std::lock_guard lock(mutex_);
  return failures_;
}

void Results::write(const Snapshot& snapshot) {
  for_each([&](Sink& sink) { sink.write(snapshot); });
}

void Results::finish(const Snapshot* last, const RunReport& report) {
  for_each([&](Sink& sink) { sink.finish(last, report); });
  if (new_config_.empty()) return;
  std::error_code error;
  std::filesystem::rename(new_config_, info_.out_dir / kEffectiveConfigFile, error);
  bool complete = false;
  {
    const std::lock_guard lock(mutex_);
    if (error) {
      failures_.push_back(fmt::format("{}: {}", (info_.out_dir / kEffectiveConfigFile).string(), error.message()));
    } else {
      note_written(info_.out_dir / kEffectiveConfigFile);
    }
    new_config_.clear();
    complete = failures_.empty();
  }
  replace_older(complete);
}

void Results::replace_older(bool complete) {
  const std::string folder = info_.out_dir.string();
  try {
    const RunFolder::Replaced replaced = folder_->finish(complete);
    if (!replaced.any) return;
    replaced_.push_back(
        fmt::format("{}: the results of an earlier run are replaced{}", folder,
                    replaced.removed.empty() ? "" : fmt::format("; removed: {}", fmt::join(replaced.removed, ", "))));
    if (!replaced.changed.empty())
      replaced_.push_back(fmt::format("{}: of an earlier run, and kept since they were changed: {}", folder,
                                      fmt::join(replaced.changed, ", ")));
    if (!replaced.left.empty())
      replaced_.push_back(fmt::format("{}: of an earlier run, and kept since this one is not complete: {}", folder,
                                      fmt::join(replaced.left, ", ")));
  } catch (const Error& error) {
    const std::lock_guard lock(mutex_);
    failures_.emplace_back(error.what());
  }
}

void Results::for_each(const std::function<void(Sink&)>& call) {
  // Two threads may call a sink, and each may take it out of service.
  for (SinkSlot& slot : sinks_) {
    std::shared_ptr<Sink> sink;
    {
      const std::lock_guard lock(mutex_);
      sink = slot.sink;
    }
    if (!sink) continue;
    std::string why;
    try {
      call(*sink);
      continue;
    } catch (const std::exception& error) {
      why = error.what();
    } catch (...) {
      why = "unknown exception";
    }
    const std::lock_guard lock(mutex_);
    if (!slot.sink) continue;
    failures_.push_back(fmt::format("sink {}: taken out of service: {}", slot.plugin, why));
    slot.sink = nullptr;
  }
}

}  // namespace waymark::host
