// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/results.hpp"

#include <fmt/format.h>

#include <exception>
#include <utility>

#include "waymark/io/output_file.hpp"

namespace waymark::host {

Results::Results(std::vector<SinkSlot> sinks, const RunInfo& info) : info_(info), sinks_(std::move(sinks)) {
  for_each([&](Sink& sink) { sink.start(info_); });
}

void Results::arrived(const Measurement& measurement) {
  for_each([&](Sink& sink) { sink.arrived(measurement); });
}

void Results::write(const Snapshot& snapshot) {
  for_each([&](Sink& sink) { sink.write(snapshot); });
}

void Results::finish(const Snapshot* last, const RunReport& report) {
  for_each([&](Sink& sink) { sink.finish(last, report); });
  if (info_.out_dir.empty() || info_.config.empty()) return;
  try {
    write_file(info_.out_dir / "config.yaml", info_.config);
  } catch (const std::exception& error) {
    failures_.emplace_back(error.what());
  }
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
