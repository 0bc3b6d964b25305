// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "checks.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kStep = 1.0;        // [s]
constexpr double kHalfWindow = 0.5;  // [s]
constexpr long kLeastSamples = 100;
constexpr Eigen::Index kLeastRows = 60;
constexpr double kClearlyBetter = 0.75;     // σ of what is left
constexpr double kLeastExplained = 0.3e-6;  // [T], more than a robot on a level floor shows

/// σ of the field along gravity [T], with the field's vertical axis as it is or the opposite one, beside what an IMU or
/// a magnetometer that is tilted (columns m_x, m_y) and iron (u_x, u_y) make of it; nothing if too little is known.
std::optional<double> wander_along_gravity(const WatchedSensor& magnetometer, const WatchedSensor& imu, double vertical,
                                           double newest) {
  Rows rows(static_cast<Eigen::Index>(newest / kStep) + 1, 6);
  for (double t = kHalfWindow; t + kHalfWindow < newest && !rows.full(); t += kStep) {
    const auto seen = tilted_field(magnetometer, imu, t, kHalfWindow);
    if (!seen) continue;
    const auto& [up, m] = *seen;
    const double up_z = std::sqrt(std::max(0.0, 1.0 - up.squaredNorm()));
    rows.A.row(rows.count) << 1.0, t, m.x(), m.y(), up.x(), up.y();
    rows.y(rows.count++) = up.dot(m.head<2>()) + vertical * up_z * m.z();
  }
  if (rows.count < kLeastRows) return std::nullopt;
  const Fit fit = fit_rows(rows);
  return fit.valid ? std::optional(fit.residual) : std::nullopt;
}

void check_dip(Case& c, std::size_t i, const WatchedSensor& imu) {
  constexpr double kMicrotesla = 1e-6;
  const WatchedSensor& sensor = c.sensor(i);
  const auto as_it_is = wander_along_gravity(sensor, imu, 1.0, c.watch.newest());
  const auto turned_over = wander_along_gravity(sensor, imu, -1.0, c.watch.newest());
  if (!as_it_is || !turned_over || *turned_over > kClearlyBetter * *as_it_is) return;
  if (*as_it_is * *as_it_is - *turned_over * *turned_over < kLeastExplained * kLeastExplained) return;
  c.add(Finding::Certainty::named, "field", {i},
        fmt::format("its magnetic field along gravity changes by {:.2g} µT as the robot tilts, by {:.2g} µT with the "
                    "vertical axis turned over",
                    *as_it_is / kMicrotesla, *turned_over / kMicrotesla),
        fmt::format("source: the sign of m_{}_t of {}", axis_along(sensor, Eigen::Vector3d::UnitZ()), sensor.name),
        0.0);
}

}  // namespace

void check_dips(Case& c) {
  const auto& sensors = c.watch.sensors();
  for (std::size_t k = 0; k < sensors.size(); ++k) {
    if (sensors[k].force_x.samples() < kLeastSamples || c.is_concerned(k)) continue;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      if (sensors[i].field_x.samples() >= kLeastSamples && !c.is_concerned(i)) check_dip(c, i, sensors[k]);
    }
  }
}

}  // namespace waymark::host::diagnosis
