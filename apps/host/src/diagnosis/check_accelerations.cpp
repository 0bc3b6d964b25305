// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kSpan = 1.0;        // [s] over which the specific force is summed up
constexpr double kHalfWindow = 0.2;  // [s], for the speed at a time
constexpr long kLeastSamples = 100;
constexpr double kSigmas = 5.0;
constexpr double kTolerance = 15.0 * kDegree;  // a vehicle that pitches and leans, an IMU that is mounted by eye
constexpr double kVague = 8.0 * kDegree;       // an angle whose σ is larger is not known
constexpr double kHalf = 0.5;                  // as much of an acceleration must show, or it is noise
constexpr double kWhole = 0.4;                 // logarithm of the scale of an acceleration that is whole
constexpr double kClearlyBetter = 0.8;         // σ of what is left, of mirrored axes

/// Turns the accelerations of the base into the specific force that the IMU shows, as complex numbers: f = c a, or
/// with mirrored axes f = c a*.
struct AccelerationFit {
  double angle = 0.0;
  double sigma = 0.0;
  double scale = 0.0;
  double residual = 0.0;
  long spans = 0;
};

/// Change of the velocity over a span, in the axes of the base in its middle.
struct VelocityChange {
  double forward;
  double left;
  double turn_rate;  ///< change of the yaw rate [rad/s]
};

std::optional<VelocityChange> velocity_change(const Track& way, const Track& yaw, double t) {
  const auto before = way.rate(t, kHalfWindow);
  const auto after = way.rate(t + kSpan, kHalfWindow);
  const auto turn = yaw.change(t, t + kSpan);
  const auto rate_before = yaw.rate(t, kHalfWindow);
  const auto rate_after = yaw.rate(t + kSpan, kHalfWindow);
  if (!before || !after || !turn || !rate_before || !rate_after) return std::nullopt;
  return VelocityChange{*after - *before, 0.5 * (*before + *after) * *turn, *rate_after - *rate_before};
}

/// What gravity adds to the specific force along the way, over a span [m/s]: the slope is that of the way to some
/// seconds before and after it, since heights are noisy.
std::optional<double> slope_change(const Track& way, const Track& height, double t) {
  constexpr double kAround = 1.0;    // [s]
  constexpr double kLeastWay = 0.5;  // [m]
  constexpr double kSteepest = 0.6;
  const auto driven = way.change(t - kAround, t + kSpan + kAround);
  const auto climbed = height.change(t - kAround, t + kSpan + kAround);
  if (!driven || !climbed || std::abs(*driven) < kLeastWay || std::abs(*climbed) > kSteepest * std::abs(*driven))
    return std::nullopt;
  return kGravity * *climbed / *driven * kSpan;
}

std::optional<AccelerationFit> acceleration_fit(const Rows& rows) {
  const Fit fit = fit_rows(rows);
  if (!fit.valid) return std::nullopt;
  const double scale = std::hypot(fit.x(0), fit.x(1));
  if (!(scale > 0.0)) return std::nullopt;
  return AccelerationFit{std::atan2(fit.x(1), fit.x(0)), std::max(fit.sigma(0), fit.sigma(1)) / scale, scale,
                         fit.residual, static_cast<long>(rows.count / 2)};
}

/// Two rows a span: f_x and f_y, of a turned and scaled acceleration, of a lever arm, and of a bias each. `height`:
/// where the ground is not level; may be null.
std::optional<AccelerationFit> fit_accelerations(const WatchedSensor& imu, const Track& way, const Track& yaw,
                                                 const Track* height, double newest, bool is_mirrored) {
  Rows rows(2 * (static_cast<Eigen::Index>(newest / kSpan) + 1), 6);
  for (double t = kHalfWindow; t + kSpan < newest && !rows.full(); t += kSpan) {
    const auto x = imu.force.x().change(t, t + kSpan);
    const auto y = imu.force.y().change(t, t + kSpan);
    const auto seen = velocity_change(way, yaw, t);
    const auto slope = height != nullptr ? slope_change(way, *height, t) : std::optional(0.0);
    if (!x || !y || !seen || !slope) continue;
    const double forward = seen->forward + *slope;
    const double left = is_mirrored ? -seen->left : seen->left;
    rows.A.row(rows.count) << forward, -left, seen->turn_rate, 0.0, kSpan, 0.0;
    rows.y(rows.count++) = *x;
    rows.A.row(rows.count) << left, forward, 0.0, seen->turn_rate, 0.0, kSpan;
    rows.y(rows.count++) = *y;
  }
  return acceleration_fit(rows);
}

/// Two rows a span, as above, of how the specific force changes beyond what its gyro shows of gravity: on any ground.
std::optional<AccelerationFit> fit_beside_gyro(const WatchedSensor& imu, const Track& way, const Track& yaw,
                                               double newest) {
  Rows rows(2 * (static_cast<Eigen::Index>(newest / kVectorSpan) + 1), 6);
  for (double t = 2.0 * kHalfWindow; t + kVectorSpan + kHalfWindow < newest && !rows.full(); t += kVectorSpan) {
    const auto change = turned_vector(imu.turn, imu.force, t, kHalfWindow);
    const auto before = acceleration(way, yaw, t);
    const auto after = acceleration(way, yaw, t + kVectorSpan);
    const auto rate_before = yaw.rate(t, kHalfWindow);
    const auto rate_after = yaw.rate(t + kVectorSpan, kHalfWindow);
    if (!change || !before || !after || !rate_before || !rate_after) continue;
    const Eigen::Vector2d seen = (change->change - change->by_turn()).head<2>();
    const Eigen::Vector2d a = *after - *before;
    const double centripetal = *rate_before * *rate_before - *rate_after * *rate_after;  // of a lever arm
    rows.A.row(rows.count) << a.x(), -a.y(), centripetal, 0.0, kVectorSpan, 0.0;
    rows.y(rows.count++) = seen.x();
    rows.A.row(rows.count) << a.y(), a.x(), 0.0, centripetal, 0.0, kVectorSpan;
    rows.y(rows.count++) = seen.y();
  }
  return acceleration_fit(rows);
}

/// An acceleration, not noise that looks like one.
bool is_whole(const AccelerationFit& fit) { return std::abs(std::log(fit.scale)) < kWhole; }

/// The same motion, as it is and mirrored.
struct AccelerationFits {
  std::optional<AccelerationFit> straight;
  std::optional<AccelerationFit> mirrored;

  /// Of the better known one that is an acceleration.
  double sigma() const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& fit : {straight, mirrored}) {
      if (fit && is_whole(*fit)) least = std::min(least, fit->sigma);
    }
    return least;
  }
};

/// With the heights with which the specific force is understood best, or without, as on level ground.
AccelerationFits best_fits(const Case& c, const WatchedSensor& imu, const Track& way, const Track& yaw) {
  const auto fits_with = [&](const Track* height) {
    return AccelerationFits{fit_accelerations(imu, way, yaw, height, c.watch.newest(), false),
                            fit_accelerations(imu, way, yaw, height, c.watch.newest(), true)};
  };
  AccelerationFits best = fits_with(nullptr);
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    if (!c.has_heights(k) || c.is_blamed(k)) continue;
    const AccelerationFits other = fits_with(&c.sensor(k).height);
    if (other.sigma() < kClearlyBetter * best.sigma()) best = other;
  }
  if (imu.turn.samples() >= kLeastSamples) {
    const auto beside_gyro = fit_beside_gyro(imu, way, yaw, c.watch.newest());
    const AccelerationFits other{beside_gyro, std::nullopt};
    if (other.sigma() < kClearlyBetter * best.sigma()) best = other;
  }
  return best;
}

void check_imu(Case& c, std::size_t i, const Observer& way, const Observer& yaw) {
  const WatchedSensor& sensor = c.sensor(i);
  if (leans_into_curves(sensor, *way.track, *yaw.track, c.watch.newest())) return;
  const auto [straight, mirrored] = best_fits(c, sensor, *way.track, *yaw.track);
  if (!straight) return;
  const std::string& name = c.sensor(way.sensor).name;
  const auto is_known = [](const AccelerationFit& fit) { return fit.sigma < kVague; };
  if (mirrored && is_whole(*mirrored) && is_known(*mirrored) && mirrored->scale > straight->scale &&
      mirrored->residual < kClearlyBetter * straight->residual) {
    c.add(Certainty::named, "acceleration", {i},
          fmt::format("its specific force is that of a mirrored motion, as {} shows ({} spans)", name, mirrored->spans),
          fmt::format("source: the order or the signs of f_x_mps2 and f_y_mps2 of {}", sensor.name),
          1.0 / mirrored->sigma);
    return;
  }
  if (!is_known(*straight)) return;
  c.comparisons.push_back({"acceleration", name, sensor.name, straight->angle / kDegree, straight->sigma / kDegree,
                           straight->spans, "degrees between them"});
  const double sigmas = beyond(straight->angle, kTolerance, straight->sigma);
  if (sigmas < kSigmas) return;
  const double yaw_deg = so3::yaw(sensor.T_base_sensor.q) / kDegree;
  c.add(Certainty::named, "acceleration", {i},
        fmt::format("its specific force points {:.1f} ± {:.1f} degrees beside the acceleration of {}",
                    straight->angle / kDegree, straight->sigma / kDegree, name),
        fmt::format("sensors.{}.base_T_sensor.yaw_deg: {:.0f} fits", sensor.name,
                    std::round(std::remainder(yaw_deg - straight->angle / kDegree, 360.0)) + 0.0),  // not −0
        sigmas);
}

}  // namespace

std::optional<Eigen::Vector2d> acceleration(const Track& way, const Track& yaw, double t) {
  const auto speed = way.rate(t, kHalfWindow);
  const auto turn = yaw.rate(t, kHalfWindow);
  const auto before = way.rate(t - kHalfWindow, kHalfWindow);
  const auto after = way.rate(t + kHalfWindow, kHalfWindow);
  if (!speed || !turn || !before || !after) return std::nullopt;
  return Eigen::Vector2d((*after - *before) / (2.0 * kHalfWindow), *speed * *turn);
}

std::optional<Angle> beside_acceleration(const Case& c, const MotionAgreement& motion, std::size_t imu) {
  const Observer* way = motion.trusted_way(c);
  const Observer* yaw = motion.yaw.trusted_track();
  const WatchedSensor& sensor = c.sensor(imu);
  if (way == nullptr || yaw == nullptr || c.is_blamed(way->sensor) || c.is_blamed(yaw->sensor)) return std::nullopt;
  if (leans_into_curves(sensor, *way->track, *yaw->track, c.watch.newest())) return std::nullopt;
  const auto fit = best_fits(c, sensor, *way->track, *yaw->track).straight;
  return fit && fit->scale > kHalf ? std::optional(Angle{fit->angle, fit->sigma}) : std::nullopt;
}

void check_accelerations(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.trusted_way(c);
  const Observer* yaw = motion.yaw.trusted_track();
  if (way == nullptr || yaw == nullptr || c.is_blamed(way->sensor) || c.is_blamed(yaw->sensor)) return;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (c.sensor(i).force.samples() >= kLeastSamples && !c.is_concerned(i)) check_imu(c, i, *way, *yaw);
  }
}

}  // namespace waymark::host::diagnosis
