// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "checks.hpp"
#include "field_turns.hpp"
#include "motion_scales.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kMicrotesla = 1e-6;
constexpr double kTolerance = 15.0 * kDegree;  // of sensors that are mounted by eye
constexpr double kSigmas = 5.0;
constexpr double kOpposite = 150.0 * kDegree;  // more looks as the opposite sign of the field's vertical axis does
constexpr double kDecides = 3.0;               // σ

/// What the gyro leaves of the field's change, and what it leaves with other axes.
std::string left_of(const FieldTurns& turns) {
  return fmt::format("{:.2g} µT are left each second, {:.2g} with other axes", turns.as_it_is / kMicrotesla,
                     turns.left / kMicrotesla);
}

/// What a magnetometer shows by what is there, if it is the one with other axes. The opposite field turns alike: of
/// both orders it is the one whose vertical axis fits, or else the one that is nearer to the right one.
Order of_field(const Order& gyro, const std::optional<bool>& is_vertical_right) {
  const Order order = gyro.transpose();
  const bool is_by_vertical = is_vertical_right && order(2, 2) != 0.0;
  const double nearness = is_by_vertical ? (*is_vertical_right ? order(2, 2) : -order(2, 2)) : order.trace();
  return nearness < 0.0 ? Order(-order) : order;
}

/// How well an angle fits what it would be if its sensor were turned by `off`, and what it would be if it were not.
enum class Shown { nothing, right, off };
Shown shown_by(const std::optional<Angle>& angle, double off) {
  if (!angle) return Shown::nothing;
  const double if_right = std::abs(angle->value);
  const double if_off = std::abs(so3::wrap(angle->value - off));
  if (std::abs(if_right - if_off) < 2.0 * kDecides * angle->sigma) return Shown::nothing;
  return if_right < if_off ? Shown::right : Shown::off;
}

std::string mounting(const WatchedSensor& sensor, double more) {
  const double yaw = std::remainder((so3::yaw(sensor.T_base_sensor.q) + more) / kDegree, 360.0);
  return fmt::format("sensors.{}.base_T_sensor.yaw_deg: {:.0f} fits", sensor.name, std::round(yaw) + 0.0);  // not −0
}

std::string vertical_sign(const WatchedSensor& magnetometer) {
  return fmt::format("source: the sign of m_{}_t of {}", axis_along(magnetometer, Eigen::Vector3d::UnitZ()),
                     magnetometer.name);
}

/// Axes of one of both are mirrored, or in another order.
void add_axes(Case& c, std::size_t imu, std::size_t i, const FieldTurns& turns) {
  // No order of the field makes a mirrored gyro.
  if (is_mirrored(turns.gyro)) {
    c.add(Certainty::named, "field", {imu},
          fmt::format("the field of {} does not turn as its gyro does: {}", c.sensor(i).name, left_of(turns)),
          "source: " + columns_of(c.sensor(imu), turns.gyro, "w_{}_radps"), 0.0);
    return;
  }
  const Order field = of_field(turns.gyro, points_as_the_earths(c, i));
  c.add(Certainty::named, "field", {i},
        fmt::format("its field does not turn as the gyro of {} does: {}", c.sensor(imu).name, left_of(turns)),
        "source: " + columns_of(c.sensor(i), field, "m_{}_t"), 0.0);
}

/// A gyro and a magnetometer of one sensor are mounted together: it is the columns of one of them.
void add_own(Case& c, std::size_t i, const FieldTurns& turns) {
  const WatchedSensor& sensor = c.sensor(i);
  c.add(Certainty::named, "field", {i}, "its field does not turn as its gyro does: " + left_of(turns),
        std::abs(turns.angle) > kOpposite
            ? vertical_sign(sensor)
            : fmt::format("source: the order or the signs of the field of {}", sensor.name),
        0.0);
}

/// A gyro that turns so many times as far as the field, which has no scale of its own for that.
void add_scale(Case& c, std::size_t imu, std::size_t i, const FieldTurns& turns) {
  const WatchedSensor& sensor = c.sensor(imu);
  c.add(Certainty::named, "field", {imu},
        fmt::format("its gyro turns {:.3g} ± {:.2g} times as far as the field{}: {}", turns.scale, turns.scale_sigma,
                    imu == i ? "" : " of " + c.sensor(i).name, left_of(turns)),
        is_near(turns.scale, 1.0 / kDegree)
            ? fmt::format("source: rates of {} times {:.9f} (degrees per second)", sensor.name, kDegree)
            : fmt::format("source: rates of {} times {:.4g}", sensor.name, 1.0 / turns.scale),
        0.0);
}

/// A mirrored gyro, or another order of the field, of a robot that turns about one axis alone.
void add_open(Case& c, std::size_t imu, std::size_t i, const FieldTurns& turns) {
  const std::string seen = fmt::format("the field of {} does not turn as the gyro of {} does: {}", c.sensor(i).name,
                                       c.sensor(imu).name, left_of(turns));
  const std::string change = fmt::format("source: the order or the signs of the field of {}", c.sensor(i).name);
  if (imu == i) {
    c.add(Certainty::named, "field", {i}, seen, change + ", or of its gyro", 0.0);
  } else {
    c.add(Certainty::one_of, "field", {i, imu}, seen, change + "; or of the gyro of " + c.sensor(imu).name, 0.0);
  }
}

/// One of two sensors is turned about the vertical axis against the other.
void add_mounting(Case& c, const MotionAgreement& motion, std::size_t imu, std::size_t i, const FieldTurns& turns) {
  const WatchedSensor& magnetometer = c.sensor(i);
  const double sigmas = beyond(turns.angle, kTolerance, turns.angle_sigma);
  if (sigmas < kSigmas) return;
  const bool may_be_sign = std::abs(turns.angle) > kOpposite;
  const Shown heading = shown_by(beside_heading(c, motion, i), turns.angle);
  const Shown force = shown_by(beside_acceleration(c, motion, imu), -turns.angle);
  const bool is_sign = may_be_sign && heading == Shown::right && points_as_the_earths(c, i) == false;
  const bool is_field = force == Shown::right || (force == Shown::nothing && (heading == Shown::off || is_sign));
  const bool is_imu = force == Shown::off || (force == Shown::nothing && heading == Shown::right && !may_be_sign);
  const std::string imu_change = mounting(c.sensor(imu), turns.angle);
  std::string field_change = mounting(magnetometer, -turns.angle);
  if (may_be_sign && heading == Shown::right) {
    field_change = vertical_sign(magnetometer);
  } else if (may_be_sign) {
    field_change = fmt::format("{}, or {}", vertical_sign(magnetometer), field_change);
  }
  const std::string seen = fmt::format(
      "the field of {} turns as if {} were turned by {:.1f} ± {:.1f} degrees beside it: {}", magnetometer.name,
      c.sensor(imu).name, std::abs(turns.angle) / kDegree, turns.angle_sigma / kDegree, left_of(turns));
  if (is_field != is_imu) {
    c.add(Certainty::named, "field", {is_field ? i : imu}, seen, is_field ? field_change : imu_change, sigmas);
  } else {
    c.add(Certainty::one_of, "field", {imu, i}, seen, imu_change + "; or " + field_change, sigmas);
  }
}

}  // namespace

std::vector<FieldMounting> check_field_axes(Case& c) {
  std::vector<FieldMounting> mountings;
  const std::size_t n = c.watch.sensors().size();
  for (std::size_t imu = 0; imu < n; ++imu) {
    for (std::size_t i = 0; i < n; ++i) {
      if (c.sensor(imu).turn.samples() == 0 || c.sensor(i).field.samples() == 0) continue;
      if (c.is_concerned(imu) || c.is_concerned(i)) continue;
      const auto turns = field_turns(c.sensor(i), c.sensor(imu), c.watch.newest());
      if (!turns) continue;
      // Turns and headings decide first where the field alone does not.
      if (turns->is_about_z || turns->is_open) {
        mountings.push_back({imu, i, *turns});
      } else if (turns->scale != 1.0) {
        add_scale(c, imu, i, *turns);
      } else {
        add_axes(c, imu, i, *turns);
      }
    }
  }
  return mountings;
}

void check_field_mountings(Case& c, const MotionAgreement& motion, const std::vector<FieldMounting>& mountings) {
  for (const FieldMounting& mounting : mountings) {
    if (c.is_concerned(mounting.imu) || c.is_concerned(mounting.magnetometer)) continue;
    if (mounting.turns.is_open) {
      add_open(c, mounting.imu, mounting.magnetometer, mounting.turns);
    } else if (mounting.imu == mounting.magnetometer) {
      add_own(c, mounting.imu, mounting.turns);
    } else {
      add_mounting(c, motion, mounting.imu, mounting.magnetometer, mounting.turns);
    }
  }
}

}  // namespace waymark::host::diagnosis
