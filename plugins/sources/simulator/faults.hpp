// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "waymark/config/config.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/math/random.hpp"
#include "windows.hpp"

namespace waymark::simulator {

/// What can go wrong with the measurements of any sensor: they come late and in another order, with the stamps of a
/// wrong clock, not at all, or without a number in them. Every decision is drawn for its own measurement, so no fault
/// changes another sensor, or another measurement.
class Faults {
 public:
  /// Reads `delay_s`, `delay_jitter_s`, `delay_jitter_law`, `stamp_offset_s`, `dead_s`, and, if `payload_type` has
  /// numbers that can be NaN, `nan_s` and `nan_probability`. `kind` keeps the draws of the sensors apart. Throws
  /// ConfigError.
  Faults(const Config& config, std::string_view payload_type, std::uint32_t kind);

  /// Whether a measurement can overtake an earlier one of the same sensor.
  bool reorder() const { return jitter_s_ > 0.0; }
  /// The least time that any measurement takes to arrive.
  Duration least_delay() const { return delay_; }
  /// When the measurement made at `time` arrives.
  Duration arrival(std::uint64_t seed, Duration time) const;
  /// What the sensor's clock shows at `time`.
  Duration stamp(Duration time) const { return time + stamp_offset_; }
  /// Whether the sensor is silent.
  bool dead(Duration time) const { return dead_.contain(time); }
  /// Turns the numbers of a measurement made at `time` into NaN, if it is one of those that go wrong.
  void spoil(std::uint64_t seed, Duration time, Payload& payload) const;

 private:
  std::uint32_t kind_;
  Duration delay_;
  double jitter_s_;
  bool exponential_;
  Duration stamp_offset_;
  Windows dead_;
  Windows nan_;
  double nan_probability_ = 0.0;
};

}  // namespace waymark::simulator
