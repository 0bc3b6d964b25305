// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "checks.hpp"
#include "fit.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kSigmas = 4.0;
constexpr double kHeadingTolerance = 10.0 * kDegree;  // declination, iron, a vehicle that does not point where it goes
constexpr double kLeastTolerance = 5.0 * kDegree;     // of a sensor that claims to have none of these
constexpr double kToleranceSigmas = 3.0;
constexpr double kScannerTolerance = 4.0 * kDegree;
constexpr double kScannerLever = 0.1;  // [m]
constexpr double kLeverSigma = 0.05;   // [m], a lever arm that is known worse is not judged
constexpr double kFarOff = 12.0;       // σ, but if it is so far off
constexpr double kAntennaLever = 0.5;  // [m], less where positions are exact:
constexpr double kLeastAntennaLever = 0.15;
constexpr double kMeasuredByHand = 0.1;  // [m]
constexpr double kLeverSigmas = 2.5;     // of the positions
constexpr std::size_t kLeastDirections = 20;
constexpr std::size_t kMostDirections = 40;  // without a common one there is none
constexpr std::size_t kParts = 8;

/// Middle of angles that lie around `about`, and its σ from the middles of parts of the log.
struct Middle {
  double value = 0.0;
  double sigma = 0.0;
  double scatter = 0.0;
  double deviation = 0.0;  ///< of a single angle (σ)
  double wander = 0.0;     ///< of that, what lasts longer than from one angle to the next (J. von Neumann, 1941)

  /// True for an angle to the same side all the time: a mounting, and no motion sideways.
  bool is_constant() const {
    constexpr double kWanders = 3.0;
    return std::abs(value) > std::max(deviation, kWanders * wander);
  }
};

std::optional<Middle> middle_of(const std::vector<double>& angles) {
  if (angles.size() < kLeastDirections) return std::nullopt;
  double s = 0.0;
  double c = 0.0;
  for (const double angle : angles) {
    s += std::sin(angle);
    c += std::cos(angle);
  }
  // Without a common direction there is no offset to speak of.
  if (std::hypot(s, c) < 0.5 * static_cast<double>(angles.size())) return std::nullopt;
  const double about = std::atan2(s, c);
  const auto middle = [&](std::size_t from, std::size_t to) {
    std::vector<double> values;
    for (std::size_t k = from; k < to; ++k) values.push_back(so3::wrap(angles[k] - about));
    return median(values);
  };
  Middle result;
  const double center = middle(0, angles.size());
  result.value = so3::wrap(about + center);
  std::vector<double> parts;
  for (std::size_t p = 0; p < kParts; ++p) {
    const double part = middle(angles.size() * p / kParts, angles.size() * (p + 1) / kParts);
    parts.push_back(std::abs(part - center));
  }
  double squares = 0.0;
  double steps = 0.0;
  for (std::size_t k = 0; k < angles.size(); ++k) {
    squares += std::pow(so3::wrap(angles[k] - result.value), 2);
    if (k > 0) steps += std::pow(so3::wrap(angles[k] - angles[k - 1]), 2);
  }
  const auto count = static_cast<double>(angles.size());
  result.deviation = std::sqrt(squares / count);
  result.wander = std::sqrt(std::max(0.0, squares / count - 0.5 * steps / (count - 1.0)));
  result.scatter = kMadToSigma * median(parts);
  result.sigma = std::max(1.25 * result.scatter / std::sqrt(static_cast<double>(kParts)), 0.1 * kDegree);
  return result;
}

/// Directions of the motion over ground, less the heading at the time.
std::vector<double> directions(const WatchedSensor& fix, const Track& heading, const Track* way) {
  std::vector<double> offsets;
  for (const Chord& chord : chords_of(fix.fixes)) {
    const double middle = 0.5 * (chord.from + chord.to);
    const auto yaw = heading.at(middle);
    const auto turned = heading.change(chord.from, chord.to);
    if (!yaw || !turned || std::abs(*turned) > 0.5) continue;
    double reverse = 0.0;
    if (way != nullptr) {
      const auto driven = way->change(chord.from, chord.to);
      if (driven && *driven < 0.0) reverse = std::numbers::pi;
    }
    offsets.push_back(so3::wrap(chord.direction + reverse - *yaw));
  }
  return offsets;
}

const Track& heading_of(const WatchedSensor& sensor) { return sensor.has_heading ? sensor.yaw : sensor.heading; }

/// A way that shows where the robot drives backwards; null if none does.
const Track* driven_way(const Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.way.trusted_track();
  return way != nullptr && !way->is_unsigned && !c.is_blamed(way->sensor) ? way->track : nullptr;
}

double yaw_deg(const WatchedSensor& sensor) { return so3::yaw(sensor.T_base_sensor.q) / kDegree; }

double in_turn(double degrees) { return std::remainder(degrees, 360.0); }

/// What has no wheels may drive beside its heading.
bool is_free(const Case& c) { return measured_way(c.watch) == nullptr; }

/// By how much the first receiver's positions move beside a heading. `way`: shows where it drives backwards; may be
/// null.
std::optional<Angle> beside_directions(const Case& c, std::size_t heading, const Track* way) {
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    if (c.sensor(k).fixes.empty() || k == heading || c.is_blamed(k)) continue;
    const auto offset = middle_of(directions(c.sensor(k), heading_of(c.sensor(heading)), way));
    if (offset) return Angle{offset->value, is_free(c) ? std::hypot(offset->sigma, offset->wander) : offset->sigma};
  }
  return std::nullopt;
}

/// A receiver's course against the way from fix to fix of its own.
void check_course(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.fixes.empty() || sensor.course.samples() == 0 || c.is_blamed(i)) return;
  const auto offset = middle_of(directions(sensor, sensor.course, nullptr));
  if (!offset) return;
  c.comparisons.push_back({"course", sensor.name + " positions", sensor.name, offset->value / kDegree,
                           offset->sigma / kDegree, 0, "degrees between them"});
  const double sigmas = beyond(offset->value, kHeadingTolerance, offset->sigma);
  if (sigmas < kSigmas) return;
  c.add(Certainty::named, "course", {i},
        fmt::format("its positions move {:.1f} ± {:.1f} degrees beside its course", offset->value / kDegree,
                    offset->sigma / kDegree),
        fmt::format("source: course of {}: another column, or it is not counted clockwise from north", sensor.name),
        sigmas);
}

void check_heading(Case& c, const MotionAgreement& motion, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  const Track& heading = heading_of(sensor);
  if (heading.samples() == 0 || c.is_blamed(i) || c.is_blamed(i, "way")) return;
  const Track* way = driven_way(c, motion);
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    const WatchedSensor& fix = c.sensor(k);
    if (fix.fixes.empty() || k == i || c.is_blamed(k)) continue;
    const std::vector<double> offsets = directions(fix, heading, way);
    const auto middle = middle_of(offsets);
    std::optional<Angle> offset;
    if (middle) offset = Angle{middle->value, middle->sigma};
    if (!offset && way != nullptr && offsets.size() >= kMostDirections && !sensor.has_heading) {
      c.add(Certainty::named, "heading", {i},
            fmt::format("its heading has no fixed angle to the direction in which the robot drives, as {} shows",
                        fix.name),
            fmt::format("source: the order and the signs of the quaternion, or of the field, of {}", sensor.name), 0.0);
      return;
    }
    // Directions that are off, but not known well enough to say so.
    const double tolerance = heading_tolerance(sensor);
    if (!offset || (kSigmas * offset->sigma > tolerance && std::abs(offset->value) > tolerance)) {
      const auto by_path = beside_path(c, motion, k, heading);
      if (by_path && (!offset || by_path->sigma < offset->sigma)) offset = by_path;
    }
    if (!offset) continue;
    c.comparisons.push_back({"heading", fix.name + " positions", sensor.name, offset->value / kDegree,
                             offset->sigma / kDegree, 0, "degrees between them"});
    const double sigmas = beyond(offset->value, tolerance, offset->sigma);
    if (sigmas < kSigmas) continue;
    if (is_free(c) && middle && !middle->is_constant()) continue;
    const double fits = std::round(in_turn(yaw_deg(sensor) - offset->value / kDegree)) + 0.0;  // not −0
    c.add(Certainty::named, "heading", {i},
          fmt::format("the robot drives {:.1f} ± {:.1f} degrees beside its heading, as {} shows",
                      offset->value / kDegree, offset->sigma / kDegree, fix.name),
          fmt::format("sensors.{}.base_T_sensor.yaw_deg: {:.0f} fits{}", sensor.name, fits,
                      std::abs(offset->value) < 40.0 * kDegree ? ", or another declination" : ""),
          sigmas);
    return;
  }
}

void check_scanner(Case& c, const MotionAgreement& motion, std::size_t i) {
  const MountingFit& mounting = motion.mountings[i];
  if (!mounting.is_known || c.is_blamed(i)) return;
  const WatchedSensor& sensor = c.sensor(i);
  const Observer* way = motion.way.trusted_track();
  if (way == nullptr || c.is_blamed(way->sensor)) return;
  c.comparisons.push_back({"direction", sensor.name + " scans", c.sensor(way->sensor).name, mounting.angle / kDegree,
                           mounting.angle_sigma / kDegree, static_cast<long>(sensor.steps.size()),
                           "degrees between them"});
  const double sigmas = beyond(mounting.angle, kScannerTolerance, mounting.angle_sigma);
  if (sigmas > kSigmas) {
    c.add(Certainty::named, "mounting", {i},
          fmt::format("it moves {:.1f} ± {:.1f} degrees beside the x axis of the base when {} drive straight on",
                      mounting.angle / kDegree, mounting.angle_sigma / kDegree, c.sensor(way->sensor).name),
          fmt::format("sensors.{}.base_T_sensor.yaw_deg: {:.1f} fits", sensor.name,
                      in_turn(yaw_deg(sensor) - mounting.angle / kDegree)),
          sigmas);
    return;
  }
  const Eigen::Vector2d lever = sensor.T_base_sensor.p.head<2>();
  const Eigen::Vector2d off = mounting.lever - lever;
  const double sigma = mounting.lever_sigma.maxCoeff();
  c.comparisons.push_back({"lever arm", sensor.name, "its base_T_sensor", off.norm(), sigma,
                           static_cast<long>(sensor.steps.size()), "m between them"});
  const bool is_known = sigma <= kLeverSigma || off.norm() > kFarOff * sigma;
  if (!is_known || c.is_concerned(i)) return;
  const double lever_sigmas = beyond(off.norm(), kScannerLever, std::max(sigma, 0.01));
  if (lever_sigmas < kSigmas) return;
  c.add(Certainty::named, "lever arm", {i},
        fmt::format("in turns it moves as if it stood {:.2f} ± {:.2f} m from where the YAML has it", off.norm(), sigma),
        fmt::format("sensors.{}.base_T_sensor.xyz_m: [{:.2f}, {:.2f}, {:.2f}] fits", sensor.name, mounting.lever.x(),
                    mounting.lever.y(), sensor.T_base_sensor.p.z()),
        lever_sigmas);
}

}  // namespace

double heading_tolerance(const WatchedSensor& sensor) {
  const double sigma = sensor.usual.yaw_error_sigma_rad;
  if (!std::isfinite(sigma)) return kHeadingTolerance;
  return std::clamp(kToleranceSigmas * sigma, kLeastTolerance, kHeadingTolerance);
}

std::optional<Angle> beside_heading(const Case& c, const MotionAgreement& motion, std::size_t heading) {
  return beside_directions(c, heading, driven_way(c, motion));
}

std::optional<Angle> positions_beside_heading(const Case& c, std::size_t heading) {
  return beside_directions(c, heading, nullptr);
}

void check_mounting(Case& c, const MotionAgreement& motion) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    check_course(c, i);
    check_heading(c, motion, i);
    check_scanner(c, motion, i);
  }
}

void check_antenna(Case& c, std::size_t i, const AntennaFit& antenna) {
  if (!antenna.is_known || c.is_blamed(i)) return;
  const WatchedSensor& sensor = c.sensor(i);
  const Eigen::Vector2d lever = sensor.usual.p_base_point.head<2>();
  const Eigen::Vector2d off = antenna.lever - lever;
  const double sigma = antenna.lever_sigma.maxCoeff();
  c.comparisons.push_back({"lever arm", sensor.name, "its base_p_antenna_m", off.norm(), sigma, 0, "m between them"});
  const double exact = kMeasuredByHand + kLeverSigmas * sensor.usual.position_sigma_m;
  const double tolerance = std::isfinite(exact) ? std::clamp(exact, kLeastAntennaLever, kAntennaLever) : kAntennaLever;
  const double sigmas = beyond(off.norm(), tolerance, std::max(sigma, 0.02));
  if (sigmas < kSigmas) return;
  c.add(Certainty::named, "lever arm", {i},
        fmt::format("in turns its positions move as if the antenna stood {:.2f} ± {:.2f} m from where the YAML has it",
                    off.norm(), sigma),
        fmt::format("sensors.{}.base_p_antenna_m: [{:.2f}, {:.2f}, {:.2f}] fits", sensor.name, antenna.lever.x(),
                    antenna.lever.y(), sensor.usual.p_base_point.z()),
        sigmas);
}

}  // namespace waymark::host::diagnosis
