// SPDX-License-Identifier: Apache-2.0
#include "watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kFixStep = 0.19;  // [s], fixes are kept at most so often
constexpr std::size_t kMostFixes = 2100;
constexpr std::size_t kMostSteps = 700;
constexpr double kAstray = 60.0;  // [s] from the newest measurement
constexpr int kMostAstray = 100;
constexpr double kShortestPair = 0.03;  // [s] from one scan of a pair to the other
constexpr double kLongestPair = 1.6;
constexpr double kUsualPair = 0.55;
constexpr double kLatePair = 3.0;     // times the usual one, after which the next scan is taken in any case
constexpr double kLatestPair = 1.51;  // [s], likewise: soon it would be too late
constexpr double kLonger = 1.05;
constexpr double kShorter = 0.8;
constexpr double kPairEvery = 0.6;       // [s] from one pair to the next
constexpr double kCourseSpeed = 0.7;     // [m/s], a slower one has no course
constexpr std::size_t kRangeEvery = 17;  // of the ranges of a scan, the share that is looked at

/// How many scans the second one of a pair lies after the first. By number, not by stamp: where stamps jitter, the
/// first one that is late enough by its stamp is one whose stamp is late.
int scans_of_pair(const WatchedSensor& sensor) {
  const double interval = sensor.intervals.quantile(0.5);
  return interval > 0.0 ? std::max(1, static_cast<int>(std::ceil(sensor.pair_step / interval))) : 1;
}

/// How many decimals a number was written with, at most kManyDecimals.
int decimals_of(double value) {
  // Of a double that was scaled, and no more: where a robot rests near a round number, further decimals are 0 or 9.
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
  double scale = 1.0;
  for (int decimals = 0; decimals < kManyDecimals; ++decimals, scale *= 10.0) {
    const double scaled = scale * value;
    if (std::abs(scaled - std::round(scaled)) < kRounding * std::max(1.0, std::abs(scaled))) return decimals;
  }
  return kManyDecimals;
}

}  // namespace

Watch::Watch(const Robot& robot) : robot_(robot), datum_(robot.settings.datum), datum_is_given_(datum_.has_value()) {
  sensors_.resize(robot.sensors.size());
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const SensorSlot& slot = robot.sensors[i];
    WatchedSensor& sensor = sensors_[i];
    sensor.name = slot.name;
    sensor.plugin = slot.plugin;
    sensor.is_watched = slot.enabled;
    sensor.delay = slot.delay;
    if (const auto& mounted = robot.rig.mountings()[i].T_base_sensor) sensor.T_base_sensor = *mounted;
    sensor.fixes.reserve(kMostFixes);
    sensor.steps.reserve(kMostSteps);
  }
}

Time Watch::stamp(double t) const { return begin_.value_or(Time{}) + from_seconds(t); }

void Watch::clear_window() {
  for (WatchedSensor& sensor : sensors_) sensor.clear_window();
  begin_.reset();
  astray_ = 0;
  newest_ = 0.0;
}

void Watch::note(const Measurement& measurement) {
  if (!sensors_[measurement.sensor].is_watched) return;
  if (const std::optional<Time> stamp = moved(measurement.stamp, -sensors_[measurement.sensor].delay))
    note_stamp(measurement.sensor, *stamp);
}

void Watch::note_stamp(std::uint32_t index, Time stamp) {
  WatchedSensor& sensor = sensors_[index];
  if (!sensor.first_stamp) sensor.first_stamp = stamp;
  sensor.last_stamp = stamp;
}

bool Watch::has_all_sensors() const {
  return std::ranges::all_of(sensors_, [](const WatchedSensor& s) { return !s.is_watched || s.first_stamp; });
}

void Watch::take(const Measurement& measurement) {
  WatchedSensor& sensor = sensors_[measurement.sensor];
  if (!sensor.is_watched) return;
  sensor.payload = measurement.payload->type();
  const std::optional<Time> stamp = moved(measurement.stamp, -sensor.delay);
  if (!stamp) return;
  if (sensor.last_stamp) sensor.intervals.add(to_seconds(*stamp - *sensor.last_stamp));
  note_stamp(measurement.sensor, *stamp);
  if (!begin_) begin_ = *stamp;
  const double t = to_seconds(*stamp - *begin_);
  take_raw(sensor, measurement);
  // A wrong clock of one sensor does not move the window; if all have leapt, a new one begins.
  if (std::abs(t - newest_) > kAstray) {
    if (++astray_ > kMostAstray) clear_window();
    return;
  }
  astray_ = 0;
  newest_ = std::max(newest_, t);
  if (measurement.payload->type() == LaserScan::kType) {
    const auto& scan = static_cast<const LaserScan&>(*measurement.payload);
    // Two scans show the motion from the middle of one sweep to that of the other.
    take_scan(sensor, t + 0.5 * scan.beam_interval_s * static_cast<double>(scan.ranges_m.size()), scan);
    return;
  }
  const SensorSlot& slot = robot_.sensors[measurement.sensor];
  if (!slot.sensor) return;
  try {
    if (!datum_ && slot.sensor->traits().is_absolute) {
      if (const auto hint = slot.sensor->start_hint(measurement, nullptr)) datum_ = hint->datum;
    }
    if (const auto motion = slot.sensor->observed_motion(measurement, datum_ ? &*datum_ : nullptr))
      take_motion(sensor, t, *motion);
  } catch (const Error&) {
    // What the sensor cannot use is counted by the filter.
  }
}

void Watch::take_raw(WatchedSensor& sensor, const Measurement& measurement) {
  const Payload& payload = *measurement.payload;
  if (payload.type() == CompassHeading::kType) {
    sensor.headings.add(std::abs(static_cast<const CompassHeading&>(payload).heading_rad));
  } else if (payload.type() == WheelSteering::kType) {
    sensor.steerings.add(std::abs(static_cast<const WheelSteering&>(payload).steering_rad));
  } else if (payload.type() == GnssFix::kType) {
    const auto& fix = static_cast<const GnssFix&>(payload);
    sensor.courses.add(std::abs(fix.course_rad));
    if (std::isfinite(fix.latitude_deg))
      sensor.decimals = std::max({sensor.decimals, decimals_of(fix.latitude_deg), decimals_of(fix.longitude_deg)});
    if (std::isfinite(fix.latitude_deg) && std::isnan(sensor.latitude_deg) &&
        (fix.latitude_deg != 0.0 || fix.longitude_deg != 0.0)) {
      sensor.latitude_deg = fix.latitude_deg;
      sensor.longitude_deg = fix.longitude_deg;
    }
  } else if (payload.type() == LaserScan::kType) {
    const auto& scan = static_cast<const LaserScan&>(payload);
    sensor.sweeps.add(std::abs(scan.beam_interval_s) * static_cast<double>(scan.ranges_m.size()));
    sensor.steps_backwards = scan.step_rad < 0.0;
    for (std::size_t k = 0; k < scan.ranges_m.size(); k += kRangeEvery) {
      const double range = scan.ranges_m[k];
      if (range > 0.0 && range < 0.98 * sensor.largest_range) sensor.ranges.add(range);
    }
  }
}

void Watch::take_motion(WatchedSensor& sensor, double t, const ObservedMotion& motion) {
  sensor.usual = motion;
  sensor.speeds.add(std::abs(std::isfinite(motion.speed_mps) ? motion.speed_mps : motion.ground_speed_mps));
  sensor.rates.add(std::abs(motion.yaw_rate_radps));
  const bool moves_sideways =
      std::isfinite(motion.lateral_speed_mps) && (motion.lateral_speed_mps != 0.0 || sensor.sideways.samples() > 0);
  if (motion.interval_s > 0.0) {
    sensor.way.add_mean(t, motion.interval_s, motion.speed_mps);
    if (moves_sideways) sensor.sideways.add_mean(t, motion.interval_s, motion.lateral_speed_mps);
    sensor.yaw.add_mean(t, motion.interval_s, motion.yaw_rate_radps);
  } else {
    sensor.way.add_rate(t, motion.speed_mps);
    if (moves_sideways) sensor.sideways.add_rate(t, motion.lateral_speed_mps);
    sensor.yaw.add_rate(t, motion.yaw_rate_radps);
  }
  if (std::isfinite(motion.yaw_rad) && std::isfinite(motion.yaw_rate_radps)) {
    sensor.heading.add_total(t, motion.yaw_rad, true);
  } else if (std::isfinite(motion.yaw_rad)) {
    sensor.has_heading = true;
    sensor.yaw.add_total(t, motion.yaw_rad, true);
  }
  if (std::isfinite(motion.ground_speed_mps)) {
    sensor.ground_way.add_rate(t, motion.ground_speed_mps);
    sensor.velocity_east.add_rate(t, motion.ground_speed_mps * std::cos(motion.course_rad));
    sensor.velocity_north.add_rate(t, motion.ground_speed_mps * std::sin(motion.course_rad));
    if (std::isfinite(motion.course_rad) && motion.ground_speed_mps > kCourseSpeed)
      sensor.course.add_total(t, motion.course_rad, true);
  }
  if (motion.p_map_point.head<2>().allFinite() && sensor.fixes.size() < kMostFixes &&
      (sensor.fixes.empty() || t - sensor.fixes.back().t > kFixStep))
    sensor.fixes.push_back({t, motion.p_map_point.head<2>()});
  sensor.height.add_total(
      t, std::isfinite(motion.height_m) ? motion.height_m : motion.p_map_point.z() - motion.p_base_point.z(), false);
  sensor.turn.add_rate(t, motion.w_base);
  if (motion.f_base.allFinite()) {
    sensor.force.add_rate(t, motion.f_base);
    sensor.forces.add(motion.f_base.norm());
    sensor.force_sum += motion.f_base;
    ++sensor.force_count;
  }
  if (motion.m_base.allFinite()) {
    sensor.fields.add(motion.m_base.norm());
    sensor.field.add_rate(t, motion.m_base);
  }
}

/// Two scans make a pair; between the pairs scans are passed over, which bounds the cost.
void Watch::take_scan(WatchedSensor& sensor, double t, const LaserScan& scan) {
  if (sensor.steps.size() >= kMostSteps) return;
  if (sensor.scan_t >= 0.0 && (t - sensor.scan_t > kLongestPair || t <= sensor.scan_t)) sensor.scan_t = -1.0;
  if (sensor.scan_t < 0.0) {
    if (t < sensor.next_scan_t || !sensor.scans[0].take(scan, sensor.largest_range)) return;
    sensor.scan_t = t;
    sensor.scans_to_second = scans_of_pair(sensor);
    return;
  }
  // Where stamps come in bursts, their usual interval says little.
  const bool is_soon = t - sensor.scan_t < std::min(kLatePair * sensor.pair_step, kLatestPair);
  if (--sensor.scans_to_second > 0 && is_soon) return;
  const double from = sensor.scan_t;
  sensor.scan_t = -1.0;
  sensor.next_scan_t = from + kPairEvery;
  if (!sensor.scans[1].take(scan, sensor.largest_range)) return;
  const std::optional<ScanMotion> motion = register_scans(sensor.scans[0], sensor.scans[1]);
  sensor.pair_step =
      motion ? std::min(kUsualPair, kLonger * sensor.pair_step) : std::max(kShortestPair, kShorter * sensor.pair_step);
  if (!motion) return;
  const Eigen::Matrix3d R = sensor.T_base_sensor.q.toRotationMatrix();
  const Eigen::Vector3d shift = R * Eigen::Vector3d(motion->x, motion->y, 0.0);
  sensor.steps.push_back(
      {from, t, shift.head<2>(), motion->is_shift_known, R(2, 2) >= 0.0 ? motion->yaw : -motion->yaw});
}

}  // namespace waymark::host::diagnosis
