// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "checks.hpp"
#include "field_turns.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kStep = 1.0;        // [s]
constexpr double kHalfWindow = 0.5;  // [s]
constexpr long kLeastSamples = 100;
constexpr Eigen::Index kLeastRows = 60;
constexpr double kClearlyBetter = 0.75;     // σ of what is left
constexpr double kLeastExplained = 0.3e-6;  // [T], more than a robot on a level floor shows

/// A magnetometer and an IMU, and the robot's own acceleration, which is no part of gravity; null where it is not
/// known.
struct Pair {
  const WatchedSensor& magnetometer;
  const WatchedSensor& imu;
  const Track* way;
  const Track* yaw;
};

/// Signs with which the specific force and the field's vertical axis are taken.
struct Signs {
  double forwards = 1.0;
  double leftwards = 1.0;
  double vertical = 1.0;
};

/// σ of the field along gravity [T], beside what an IMU or a magnetometer that is tilted (columns m_x, m_y) and iron
/// (u_x, u_y) make of it; infinite if too little is known.
double wander_along_gravity(const Pair& pair, const Signs& signs, double newest) {
  Rows rows(static_cast<Eigen::Index>(newest / kStep) + 1, 6);
  for (double t = kHalfWindow; t + kHalfWindow < newest && !rows.full(); t += kStep) {
    const auto seen = tilted_field(pair.magnetometer, pair.imu, t, kHalfWindow);
    const auto own = pair.way != nullptr ? acceleration(*pair.way, *pair.yaw, t) : Eigen::Vector2d(0.0, 0.0);
    if (!seen || !own) continue;
    const Eigen::Vector2d lean =
        seen->lean.cwiseProduct(Eigen::Vector2d(signs.forwards, signs.leftwards)) - *own / kGravity;
    const Eigen::Vector3d& m = seen->field;
    const double up = std::sqrt(std::max(0.0, 1.0 - lean.squaredNorm()));
    rows.A.row(rows.count) << 1.0, t, m.x(), m.y(), lean.x(), lean.y();
    rows.y(rows.count++) = lean.dot(m.head<2>()) + signs.vertical * up * m.z();
  }
  if (rows.count < kLeastRows) return std::numeric_limits<double>::infinity();
  const Fit fit = fit_rows(rows);
  return fit.valid ? fit.residual : std::numeric_limits<double>::infinity();
}

/// True if accelerations show that the IMU is not turned by 180°, which would look like a field turned over.
bool is_turned_right(const Case& c, const MotionAgreement& motion, std::size_t imu) {
  constexpr double kMostSigmas = 3.0;
  const auto beside = beside_acceleration(c, motion, imu);
  return beside && std::abs(beside->value) + kMostSigmas * beside->sigma < 90.0 * kDegree;
}

/// A sign of the field's vertical axis, or of the specific force along one in the plane: which one leaves least?
void check_dip(Case& c, const MotionAgreement& motion, std::size_t i, std::size_t k) {
  constexpr double kMicrotesla = 1e-6;
  const WatchedSensor& magnetometer = c.sensor(i);
  const WatchedSensor& imu = c.sensor(k);
  const Observer* way = motion.trusted_way(c);
  const Observer* yaw = motion.yaw.trusted_track();
  const bool is_known =
      way != nullptr && yaw != nullptr && !c.is_concerned(way->sensor) && !c.is_concerned(yaw->sensor);
  const Pair pair{magnetometer, imu, is_known ? way->track : nullptr, is_known ? yaw->track : nullptr};
  const auto wander = [&](const Signs& signs) { return wander_along_gravity(pair, signs, c.watch.newest()); };
  const double as_it_is = wander({});
  if (!std::isfinite(as_it_is)) return;
  const double over = wander({.vertical = -1.0});
  const double forwards = wander({.forwards = -1.0});
  const double leftwards = wander({.leftwards = -1.0});
  const double least = std::min({over, forwards, leftwards});
  if (least > kClearlyBetter * as_it_is) return;
  if (as_it_is * as_it_is - least * least < kLeastExplained * kLeastExplained) return;
  const auto seen = [&](const char* what) {
    return fmt::format(
        "the magnetic field of {} along gravity changes by {:.2g} µT as the robot tilts, by {:.2g} µT with "
        "{}",
        magnetometer.name, as_it_is / kMicrotesla, least / kMicrotesla, what);
  };
  if (over > least) {
    const Eigen::Vector3d axis = forwards > least ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
    c.add(Finding::Certainty::named, "gravity", {k}, seen("one sign of the specific force turned over"),
          fmt::format("source: the sign of f_{}_mps2 of {}", axis_along(imu, axis), imu.name), 0.0);
    return;
  }
  // Where a gyro shows that the field is right, it is the specific force that is not the vertical.
  if (confirms_vertical(magnetometer, imu, c.watch.newest())) return;
  const bool is_field = is_turned_right(c, motion, k);
  const std::string change = fmt::format("source: the sign of m_{}_t of {}",
                                         axis_along(magnetometer, Eigen::Vector3d::UnitZ()), magnetometer.name);
  if (is_field) {
    c.add(Finding::Certainty::named, "field", {i}, seen("its vertical axis turned over"), change, 0.0);
  } else {
    c.add(Finding::Certainty::one_of, "field", {i, k}, seen("its vertical axis turned over"),
          fmt::format("{}; or sensors.{}.base_T_sensor.yaw_deg: 180 more fits", change, imu.name), 0.0);
  }
}

/// Latitude of the robot [degrees]; NaN if nothing shows it for certain.
double latitude_of(const Case& c) {
  if (c.watch.datum_is_given()) return c.watch.datum()->latitude_deg;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (!std::isnan(c.sensor(i).latitude_deg) && !c.is_concerned(i)) return c.sensor(i).latitude_deg;
  }
  return ObservedMotion::kUnknown;
}

/// True if what gravity shows of some IMU is that the robot stands on its head.
bool is_overturned(const Case& c) {
  return std::ranges::any_of(c.watch.sensors(),
                             [](const WatchedSensor& s) { return s.force_count > 0 && s.force_sum.z() < 0.0; });
}

}  // namespace

std::optional<bool> points_as_the_earths(const Case& c, std::size_t i) {
  // The magnetic equator winds within some 15° about the Earth's.
  constexpr double kLeastLatitude = 30.0;  // [degrees]
  constexpr double kSteep = 0.5;           // vertical part of a field that is no level one
  const double latitude = latitude_of(c);
  if (!(std::abs(latitude) > kLeastLatitude) || is_overturned(c)) return std::nullopt;
  std::vector<double> upwards;
  for (double t = kHalfWindow; t + kHalfWindow < c.watch.newest(); t += kStep) {
    if (const auto field = c.sensor(i).field.rate(t, kHalfWindow)) upwards.push_back(field->z() / field->norm());
  }
  if (static_cast<Eigen::Index>(upwards.size()) < kLeastRows) return std::nullopt;
  const double up = median(upwards);
  return std::abs(up) < kSteep ? std::nullopt : std::optional(up * latitude < 0.0);
}

void check_dips(Case& c, const MotionAgreement& motion) {
  const auto& sensors = c.watch.sensors();
  for (std::size_t k = 0; k < sensors.size(); ++k) {
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      if (sensors[k].force.samples() < kLeastSamples || sensors[i].field.samples() < kLeastSamples) continue;
      if (!c.is_concerned(k) && !c.is_concerned(i)) check_dip(c, motion, i, k);
    }
  }
}

}  // namespace waymark::host::diagnosis
