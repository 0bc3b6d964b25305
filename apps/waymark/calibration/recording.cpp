// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "apps/waymark/calibration/log_reader.hpp"
#include "apps/waymark/calibration/scan_pairs.hpp"
#include "waymark/base/error.hpp"
#include "waymark/host/robot.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::calibration {

namespace {

constexpr double kGapSeconds = 0.5;  // without samples: the motion in it is not known

/// What one pass through the filter gives.
struct FilterPass {
  std::vector<PathPoint> path;
  std::set<std::uint64_t> held_out;  // by number in the log
  std::optional<Datum> datum;
};

FilterPass filter(const std::filesystem::path& yaml, const std::vector<Config::Override>& overrides,
                  std::optional<double> until_s) {
  LogReader log(yaml, overrides, until_s);
  FilterPass pass;
  const auto note = [&](const Snapshot& snapshot) {
    if (snapshot.fate() == Fate::held_out) pass.held_out.insert(snapshot.measurement().sequence);
    if (!snapshot.started()) return;
    const Pose& pose = snapshot.belief().mean.T_map_base;
    const double t = to_seconds(snapshot.stamp() - log.first().value());
    if (!pass.path.empty() && t < pass.path.back().t) return;
    const double before = pass.path.empty() ? 0.0 : pass.path.back().pose.z();
    const PathPoint point{t, {pose.p.x(), pose.p.y(), before + so3::wrap(pose.yaw() - before)}};
    if (!pass.path.empty() && t == pass.path.back().t) pass.path.pop_back();
    pass.path.push_back(point);
  };
  const std::unique_ptr<Fusion> fusion = log.robot().fusion(note);
  while (std::optional<Measurement> m = log.next()) fusion->add(std::move(*m));
  fusion->finish();
  if (pass.path.size() < 2) throw Error(fmt::format("{}: the filter has not started: see waymark run", yaml.string()));
  pass.datum = fusion->datum();
  return pass;
}

/// Sideways, to the left: `ObservedMotion` does not have it.
double lateral_speed(const Measurement& m) {
  if (m.payload->type() == BodyTwist::kType) return m.as<BodyTwist>().v_y_mps;
  if (m.payload->type() != PoseIncrement::kType) return 0.0;
  const auto& step = m.as<PoseIncrement>();
  const double half = 0.5 * step.yaw_rad;
  const double along = std::abs(half) < 1e-4 ? 1.0 - half * half / 3.0 : half / std::tan(half);
  return (along * step.y_m - half * step.x_m) / step.interval_s;
}

/// The measurements of one sensor with what they say, in order of their stamps.
struct Seen {
  double t;
  ObservedMotion motion;
  std::optional<StartHint> hint;
  double lateral;
};

/// Sorts what one sensor has seen into what it is.
void add(const std::string& name, std::vector<Seen>& seen, Recording& recording) {
  std::ranges::stable_sort(seen, {}, &Seen::t);
  Wheels wheels;
  Gyro gyro;
  Positions positions;
  Headings headings;
  for (const Seen& one : seen) {
    const ObservedMotion& motion = one.motion;
    const bool turns = std::isfinite(motion.yaw_rate_radps);
    if (std::isfinite(motion.speed_mps)) {
      wheels.speed.add(one.t, motion.speed_mps, motion.interval_s);
      wheels.lateral.add(one.t, std::isfinite(one.lateral) ? one.lateral : 0.0, motion.interval_s);
      if (turns) wheels.rate.add(one.t, motion.yaw_rate_radps, motion.interval_s);
      wheels.yaw_scales_with_speed = motion.yaw_scales_with_speed;
    } else if (turns) {
      gyro.rate.add(one.t, motion.yaw_rate_radps, motion.interval_s);
    }
    if (one.hint && motion.p_map_point.head<2>().allFinite()) {
      const double slow = one.hint->slow_sigma_m;
      positions.fixes.push_back({one.t, motion.p_map_point.head<2>(),
                                 std::sqrt(std::max(1e-8, one.hint->sigma_m * one.hint->sigma_m - slow * slow))});
      positions.lever = motion.p_base_point.head<2>();
      positions.slow_sigma = std::max(positions.slow_sigma, slow);
      positions.slow_tau_s = slow > 0.0 ? one.hint->slow_tau_s : 0.0;
    }
    if (one.hint && one.hint->yaw_rad && std::isfinite(motion.yaw_rad))
      headings.headings.push_back({one.t, motion.yaw_rad, one.hint->yaw_sigma_rad});
  }
  wheels.sensor = gyro.sensor = positions.sensor = headings.sensor = name;
  if (wheels.speed.times().size() > 1) recording.wheels.push_back(std::move(wheels));
  if (gyro.rate.times().size() > 1) recording.gyros.push_back(std::move(gyro));
  if (!positions.fixes.empty()) recording.positions.push_back(std::move(positions));
  if (!headings.headings.empty()) recording.headings.push_back(std::move(headings));
}

bool is_fused(const FuseRule& rule) { return rule.mode != FuseRule::Mode::none && rule.mode != FuseRule::Mode::start; }

}  // namespace

void Integral::add(double t, double rate, double interval_s) {
  if (interval_s > 0.0) {
    if (t_.empty() || t > t_.back()) {
      const bool gap = !t_.empty() && t - t_.back() > kGapSeconds;
      const double bridged = t_.empty() ? 0.0 : (t - t_.back()) * rate;
      is_gap_.push_back(gap);
      sum_.push_back(t_.empty() ? 0.0 : sum_.back() + (gap ? 0.0 : bridged));
      t_.push_back(t);
    }
    // Where intervals overlap by what stamps jitter, what is left of it counts.
    const double end = t + interval_s;
    if (end > t_.back()) {
      sum_.push_back(sum_.back() + rate * (end - t_.back()));
      is_gap_.push_back(interval_s > kGapSeconds);
      t_.push_back(end);
    }
    return;
  }
  if (!t_.empty() && t <= t_.back()) return;
  sum_.push_back(t_.empty() ? 0.0 : sum_.back() + 0.5 * (rate + last_rate_) * (t - t_.back()));
  is_gap_.push_back(!t_.empty() && t - t_.back() > kGapSeconds);
  t_.push_back(t);
  last_rate_ = rate;
}

double Integral::at(double t, std::size_t interval) const {
  const double share = (t - t_[interval]) / (t_[interval + 1] - t_[interval]);
  return sum_[interval] + share * (sum_[interval + 1] - sum_[interval]);
}

std::optional<double> Integral::mean(double a, double b) const {
  if (t_.size() < 2 || a < t_.front() || b > t_.back() || !(b > a)) return std::nullopt;
  const auto interval_of = [&](double t) {
    const auto next = std::upper_bound(t_.begin(), t_.end(), t);
    return std::clamp(static_cast<std::ptrdiff_t>(next - t_.begin()) - 1, std::ptrdiff_t{0},
                      static_cast<std::ptrdiff_t>(t_.size()) - 2);
  };
  const auto from = static_cast<std::size_t>(interval_of(a));
  const auto to = static_cast<std::size_t>(interval_of(b));
  for (std::size_t i = from + 1; i <= to + (b > t_[to] ? 1 : 0); ++i) {
    if (is_gap_[i]) return std::nullopt;
  }
  return (at(b, to) - at(a, from)) / (b - a);
}

Recording read_recording(const std::filesystem::path& yaml, const std::vector<Config::Override>& overrides,
                         std::optional<double> until_s) {
  FilterPass pass = filter(yaml, overrides, until_s);
  LogReader log(yaml, overrides, until_s);
  const host::Robot& robot = log.robot();
  std::map<std::uint32_t, std::vector<Seen>> seen;
  std::map<std::uint32_t, ScanPairs> scans;
  while (std::optional<Measurement> m = log.next()) {
    if (pass.held_out.contains(m->sequence)) continue;
    const SensorSlot& slot = robot.sensors[m->sensor];
    const std::optional<Time> stamp = moved(m->stamp, -slot.delay);
    if (!stamp || !slot.enabled || !is_fused(slot.fuse)) continue;
    const double t = to_seconds(*stamp - log.first().value());
    if (m->payload->type() == LaserScan::kType) {
      const auto mounted = robot.rig.mountings()[m->sensor].T_base_sensor;
      const auto [at, is_new] = scans.try_emplace(m->sensor, mounted.value_or(Pose{}));
      at->second.take(t, m->as<LaserScan>());
      continue;
    }
    if (slot.sensor == nullptr) continue;
    try {
      const Datum* datum = pass.datum ? &*pass.datum : nullptr;
      std::optional<ObservedMotion> motion = slot.sensor->observed_motion(*m, datum);
      if (!motion) continue;
      seen[m->sensor].push_back({t, *motion, slot.sensor->start_hint(*m, datum), lateral_speed(*m)});
    } catch (const DataError&) {
      continue;  // the filter counts it
    }
  }
  Recording recording;
  for (auto& [sensor, list] : seen) add(robot.sensors[sensor].name, list, recording);
  for (auto& [sensor, pairs] : scans) {
    if (!pairs.motions().empty())
      recording.scanners.push_back({robot.sensors[sensor].name, pairs.lever(), pairs.motions()});
  }
  if (recording.wheels.empty())
    throw Error(
        fmt::format("{}: no sensor of this log gives a speed; wheels or another odometry are needed", yaml.string()));
  recording.path = std::move(pass.path);
  return recording;
}

}  // namespace waymark::calibration
