// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/results.hpp"

#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <system_error>
#include <utility>

#include "waymark/io/output_file.hpp"

namespace waymark::host {

namespace {

constexpr const char* kConfig = "config.yaml";
constexpr const char* kNewConfig = "config.yaml.new";

}  // namespace

Results::Results(std::vector<SinkSlot> sinks, const RunInfo& info, bool with_config)
    : info_(info), sinks_(std::move(sinks)) {
  if (with_config) {
    // Before any sink opens a file: a full disk then leaves older results as they are.
    write_file(info_.out_dir / kNewConfig, info_.config);
    new_config_ = info_.out_dir / kNewConfig;
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

void Results::write(const Snapshot& snapshot) {
  for_each([&](Sink& sink) { sink.write(snapshot); });
}

void Results::finish(const Snapshot* last, const RunReport& report) {
  for_each([&](Sink& sink) { sink.finish(last, report); });
  if (new_config_.empty()) return;
  std::error_code error;
  std::filesystem::rename(new_config_, info_.out_dir / kConfig, error);
  if (error) failures_.push_back(fmt::format("{}: {}", (info_.out_dir / kConfig).string(), error.message()));
  new_config_.clear();
}

void Results::for_each(const std::function<void(Sink&)>& call) {
  for (SinkSlot& slot : sinks_) {
    if (!slot.sink) continue;
    std::string why;
    try {
      call(*slot.sink);
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

}  // namespace waymark::host
