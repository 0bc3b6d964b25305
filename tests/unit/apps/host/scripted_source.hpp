// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::host {

inline Measurement reading(double stamp_s, std::uint32_t channel = 0) {
  auto payload = std::make_shared<BodyTwist>();
  payload->v_x_mps = 1.0;
  Measurement measurement;
  measurement.stamp = measurement.arrival = Time{} + from_seconds(stamp_s);
  measurement.sensor = channel;
  measurement.payload = payload;
  return measurement;
}

/// Delivers a list; a live one then waits for `stop`.
class Scripted final : public Source {
 public:
  Scripted(std::vector<std::string> sensors, std::vector<Measurement> script, bool live = false)
      : script_(std::move(script)), live_(live) {
    for (std::string& sensor : sensors) channels_.push_back({std::move(sensor), std::string(BodyTwist::kType)});
  }
  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override {
    if (next_ < script_.size()) return script_[next_++];
    while (live_ && !stopped) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return std::nullopt;
  }
  bool is_live() const override { return live_; }
  void stop() override { stopped = true; }

  std::atomic<bool> stopped{false};

 private:
  std::vector<Channel> channels_;
  std::vector<Measurement> script_;
  std::size_t next_ = 0;
  bool live_;
};

}  // namespace waymark::host
