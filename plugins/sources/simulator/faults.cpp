// SPDX-License-Identifier: Apache-2.0
#include "faults.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "streams.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::simulator {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void spoil(Payload& payload) {
  if (payload.type() == WheelSpeeds::kType) {
    auto& wheels = static_cast<WheelSpeeds&>(payload);
    wheels.left_mps = wheels.right_mps = kNaN;
  } else if (payload.type() == GnssFix::kType) {
    static_cast<GnssFix&>(payload).p_map_antenna.setConstant(kNaN);
  } else if (payload.type() == LaserScan::kType) {
    std::ranges::fill(static_cast<LaserScan&>(payload).ranges_m, std::numeric_limits<float>::quiet_NaN());
  } else if (payload.type() == PointCloud::kType) {
    auto& cloud = static_cast<PointCloud&>(payload);
    std::ranges::fill(cloud.points_m, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  } else if (payload.type() == ImuSample::kType) {
    auto& imu = static_cast<ImuSample&>(payload);
    imu.w_sensor.setConstant(kNaN);
    imu.f_sensor.setConstant(kNaN);
    imu.m_sensor.setConstant(kNaN);
  } else if (payload.type() == CompassHeading::kType) {
    static_cast<CompassHeading&>(payload).heading_rad = kNaN;
  } else if (payload.type() == RadarTargets::kType) {
    for (RadarTargets::One& one : static_cast<RadarTargets&>(payload).targets)
      one.range_m = one.azimuth_rad = one.elevation_rad = one.radial_mps = kNaN;
  }
}

}  // namespace

Faults::Faults(const Config& config, std::string_view payload_type, std::uint32_t kind)
    : kind_(kind),
      delay_(from_seconds(config.number_in(
          {"delay_s", "s", "least time from a measurement to its arrival: a receiver's latency"}, 0.0, 60.0, 0.0))),
      jitter_s_(config.number_in({"delay_jitter_s", "s",
                                  "each measurement's own extra delay, up to this (`uniform`) or this on the average "
                                  "(`exponential`); so measurements overtake each other"},
                                 0.0, 60.0, 0.0)),
      exponential_(config.choice({"delay_jitter_law", "distribution of that extra delay"}, {"uniform", "exponential"},
                                 "uniform") == "exponential"),
      stamp_offset_(from_seconds(config.number_in({"stamp_offset_s", "s",
                                                   "a wrong clock: stamp = time of the measurement + offset; arrival "
                                                   "is not changed, so a stamp can lie in the future"},
                                                  -60.0, 60.0, 0.0))),
      dead_(config, {"dead_s", "s", "begin, end of spans in which the sensor is silent; it dies and comes back"}),
      nan_(payload_type == Image::kType
               ? Windows()
               : Windows(config, {"nan_s", "s", "begin, end of spans in which all its numbers are NaN"})) {
  if (payload_type != Image::kType) {
    nan_probability_ =
        config.number_in({"nan_probability", "share of its measurements whose numbers are all NaN"}, 0.0, 1.0, 0.0);
  }
}

Duration Faults::arrival(std::uint64_t seed, Duration time) const {
  const Duration earliest = time + delay_;
  if (!reorder()) return earliest;
  const double draw = stream(seed, Draw::jitter, time, kind_).uniform();
  return earliest + from_seconds(jitter_s_ * (exponential_ ? -std::log(draw) : draw));
}

void Faults::spoil(std::uint64_t seed, Duration time, Payload& payload) const {
  const bool by_chance = nan_probability_ > 0.0 && stream(seed, Draw::gaps, time, kind_).uniform() < nan_probability_;
  if (by_chance || nan_.contain(time)) simulator::spoil(payload);
}

}  // namespace waymark::simulator
