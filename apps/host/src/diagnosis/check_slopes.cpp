// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"
#include "observers.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kSpan = 5.0;        // [s], long, since heights are noisy
constexpr double kHalfWindow = 0.2;  // [s], for the speed at a time
constexpr double kLeastWay = 2.5;    // [m] of a span that has a slope
constexpr double kSteepest = 2.0;    // in feet, too
constexpr long kLeastSamples = 100;
constexpr double kSigmas = 5.0;
constexpr double kLeastSign = 0.3;          // of an acceleration whose sign is known
constexpr double kSlow = 0.3;               // [m/s], a slower way has no slope
constexpr double kRollSigmas = 3.0;         // by which a vehicle leans that is not compared
constexpr double kSign = 0.5;               // as much of an acceleration must show, with the opposite sign
constexpr double kLean = 10.0 * kDegree;    // a mounting by eye, a floor that is not level
constexpr double kLeastCorrelation2 = 0.3;  // of slopes that are more than noise
constexpr double kScaleTolerance = 0.5;     // of a slope: a vehicle that pitches
constexpr double kFoot = 0.3048;
constexpr double kNearFoot = 0.15;

/// How the specific force follows the motion, forwards and to the left: f_x = b g climb / way + a dv/dt + lean,
/// f_y = a v dψ/dt + lean.
struct ForceFit {
  bool is_known = false;
  double acceleration = 0.0;  ///< a; 1 is right
  double acceleration_sigma = 0.0;
  bool is_slope_known = false;
  SlopeBounds slope;  ///< b; 1 is right
  double slope_sigma = 0.0;
  double lean = 0.0;  ///< that neither explains [m/s²]
  double lean_sigma = 0.0;
  long spans = 0;

  bool has_opposite_sign() const { return is_known && acceleration + kSigmas * acceleration_sigma < -kSign; }
};

/// `height`: null on level ground.
ForceFit fit_forwards(const WatchedSensor& imu, const Track& way, const Track* height, double newest) {
  Rows rows(static_cast<Eigen::Index>(newest / kSpan) + 1, height != nullptr ? 3 : 2);
  for (double t = kHalfWindow; t + kSpan < newest && !rows.full(); t += kSpan) {
    const auto force = imu.force.x().change(t, t + kSpan);
    const auto before = way.rate(t, kHalfWindow);
    const auto after = way.rate(t + kSpan, kHalfWindow);
    if (!force || !before || !after) continue;
    rows.A.row(rows.count).head<2>() << *after - *before, kSpan;
    if (height != nullptr) {
      const auto driven = way.change(t, t + kSpan);
      const auto climbed = height->change(t, t + kSpan);
      if (!driven || !climbed || std::abs(*driven) < kLeastWay || std::abs(*climbed) > kSteepest * std::abs(*driven))
        continue;
      rows.A(rows.count, 2) = kGravity * *climbed / *driven * kSpan;
    }
    rows.y(rows.count++) = *force;
  }
  ForceFit result;
  const Fit fit = fit_rows(rows);
  if (!fit.valid) return result;
  result = {true, fit.x(0), fit.sigma(0), false, {}, 0.0, fit.x(1), fit.sigma(1), static_cast<long>(rows.count)};
  if (height != nullptr) {
    result.slope = slope_bounds(rows, fit, 2);
    result.slope_sigma = fit.sigma(2);
    result.is_slope_known = result.slope.correlation2 > kLeastCorrelation2;
  }
  return result;
}

ForceFit fit_leftwards(const WatchedSensor& imu, const Track& way, const Track& yaw, double newest) {
  constexpr double kShort = 1.0;  // [s], or turns to both sides cancel
  Rows rows(static_cast<Eigen::Index>(newest / kShort) + 1, 2);
  for (double t = kHalfWindow; t + kShort < newest && !rows.full(); t += kShort) {
    const auto force = imu.force.y().change(t, t + kShort);
    const auto driven = way.change(t, t + kShort);
    const auto turned = yaw.change(t, t + kShort);
    if (!force || !driven || !turned) continue;
    rows.A.row(rows.count) << *driven * *turned / kShort, kShort;
    rows.y(rows.count++) = *force;
  }
  const Fit fit = fit_rows(rows);
  if (!fit.valid) return {};
  return {true, fit.x(0), fit.sigma(0), false, {}, 0.0, fit.x(1), fit.sigma(1), static_cast<long>(rows.count)};
}

/// True if its own gyro shows that it leans into curves so far that gravity takes half of their acceleration away, or
/// more: it rolls as the acceleration changes.
bool rolls_into_curves(const WatchedSensor& imu, const Track& way, const Track& yaw, double newest) {
  constexpr double kShort = 1.0;  // [s]
  if (imu.turn.samples() < kLeastSamples) return false;
  Rows rows(static_cast<Eigen::Index>(newest / kShort) + 1, 2);
  for (double t = 2.0 * kHalfWindow; t + kShort + 2.0 * kHalfWindow < newest && !rows.full(); t += kShort) {
    const auto rolled = imu.turn.x().change(t, t + kShort);
    const auto before = acceleration(way, yaw, t);
    const auto after = acceleration(way, yaw, t + kShort);
    if (!rolled || !before || !after) continue;
    rows.A.row(rows.count) << after->y() - before->y(), kShort;
    rows.y(rows.count++) = kGravity * *rolled;
  }
  const Fit fit = fit_rows(rows);
  return fit.valid && fit.x(0) + kRollSigmas * fit.sigma(0) < kSign - 1.0;
}

void check_signs(Case& c, std::size_t i, const ForceFit& forwards, const ForceFit& leftwards, const Observer& way) {
  const bool is_slope_opposite =
      forwards.is_slope_known && forwards.slope.high + kSigmas * forwards.slope_sigma < -kSign;
  const bool is_forwards = forwards.has_opposite_sign() || is_slope_opposite;
  if (!is_forwards && !leftwards.has_opposite_sign()) return;
  const ForceFit& shown = is_forwards ? forwards : leftwards;
  const bool is_by_slope = is_forwards && !forwards.has_opposite_sign();
  c.add(Certainty::named, "acceleration", {i},
        fmt::format("its specific force {} is {:.2g} ± {:.2g} times the acceleration{} that {} shows ({} spans)",
                    is_forwards ? "forwards" : "to the left", is_by_slope ? shown.slope.high : shown.acceleration,
                    is_by_slope ? shown.slope_sigma : shown.acceleration_sigma, is_by_slope ? " on slopes" : "",
                    c.sensor(way.sensor).name, shown.spans),
        fmt::format("source: the sign of f_{}_mps2 of {}",
                    axis_along(c.sensor(i), is_forwards ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY()),
                    c.sensor(i).name),
        0.0);
}

/// Root mean square of the heights about their mean [m].
double spread_of(const Track& height, double newest) {
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (double t = 0.0; t <= newest; t += kSpan) {
    const auto z = height.at(t);
    if (!z) continue;
    sum += *z;
    squares += *z * *z;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(std::max(0.0, squares / count - std::pow(sum / count, 2))) : 0.0;
}

/// The forces of a way whose slopes some sensor's heights show.
struct Climb {
  std::size_t with_heights;
  ForceFit fit;
};

/// With the heights of every sensor that shows slopes.
std::vector<Climb> climbs_of(const Case& c, std::size_t i, const Track& way) {
  std::vector<Climb> climbs;
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    if (k == i || !c.has_heights(k)) continue;
    const ForceFit fit = fit_forwards(c.sensor(i), way, &c.sensor(k).height, c.watch.newest());
    if (fit.is_slope_known) climbs.push_back({k, fit});
  }
  return climbs;
}

/// The sign of a factor; 0 if it is not known, or near 0.
int sign_of(double factor, double sigma) {
  if (std::abs(factor) - kRollSigmas * sigma < kLeastSign) return 0;
  return factor > 0.0 ? 1 : -1;
}

/// Whether the heights rise where a gyro turns the bow up: 1, or −1 for the contrary; 0 if that is not known.
int sign_of_heights_by_gyro(const WatchedSensor& imu, const Track& way, const Track& height, double newest) {
  constexpr double kApart = 3.0;  // [s] between two slopes
  constexpr double kHalf = 1.5;   // [s] over which a slope is taken, before and after
  if (imu.turn.samples() < kLeastSamples) return 0;
  const auto slope = [&](double t) -> std::optional<double> {
    const auto driven = way.change(t - kHalf, t + kHalf);
    const auto climbed = height.change(t - kHalf, t + kHalf);
    if (!driven || !climbed || std::abs(*driven) < kHalf * kSlow) return std::nullopt;
    return std::clamp(*climbed / *driven, -1.0, 1.0);
  };
  Rows rows(static_cast<Eigen::Index>(newest / kApart) + 1, 2);
  for (double t = kHalf; t + kApart + kHalf < newest && !rows.full(); t += kApart) {
    const auto before = slope(t);
    const auto after = slope(t + kApart);
    const auto pitched = imu.turn.y().change(t, t + kApart);
    if (!before || !after || !pitched) continue;
    rows.A.row(rows.count) << -*pitched, kApart;
    rows.y(rows.count++) = *after - *before;
  }
  const Fit fit = fit_rows(rows);
  return fit.valid ? sign_of(fit.x(0), fit.sigma(0)) : 0;
}

/// Heights that fall where gravity shows that the way climbs: they have the opposite sign, or the IMU has it. `yaw`:
/// may be null. `others_climb`: other heights rise where gravity shows it.
void judge_fall(Case& c, std::size_t i, const Climb& climb, const Observer& way, const Observer* yaw,
                bool others_climb) {
  const ForceFit& forwards = climb.fit;
  if (!(forwards.slope.high + kSigmas * forwards.slope_sigma < -kSign)) return;
  const WatchedSensor& imu = c.sensor(i);
  const Track& height = c.sensor(climb.with_heights).height;
  const int by_gyro = sign_of_heights_by_gyro(imu, *way.track, height, c.watch.newest());
  if (by_gyro > 0) return;  // f_x has the opposite sign
  // Accelerations, in which heights have no part.
  const int by_acceleration = forwards.is_known ? sign_of(forwards.acceleration, forwards.acceleration_sigma) : 0;
  const int ahead = others_climb ? 1 : by_acceleration;
  const bool shows_left = yaw != nullptr && !leans_into_curves(imu, *way.track, *yaw->track, c.watch.newest());
  const ForceFit leftwards = shows_left ? fit_leftwards(imu, *way.track, *yaw->track, c.watch.newest()) : ForceFit{};
  const int aside = leftwards.is_known ? sign_of(leftwards.acceleration, leftwards.acceleration_sigma) : 0;
  if (ahead < 0 || (ahead == 0 && aside < 0)) return;  // the IMU is turned round
  const std::string& name = c.sensor(climb.with_heights).name;
  // A gyro that contradicts the heights may be turned round with its IMU, which accelerations to the left show, too.
  const bool is_named = ahead > 0 || (by_gyro < 0 && aside > 0);
  c.add(
      is_named ? Certainty::named : Certainty::one_of, "height",
      is_named ? std::vector{climb.with_heights} : std::vector{climb.with_heights, i},
      fmt::format("{}its heights climb {:.2g} ± {:.2g} times as much as gravity in {} shows",
                  is_named ? "" : name + ": ", 1.0 / forwards.slope.high,
                  forwards.slope_sigma / std::pow(forwards.slope.high, 2), imu.name),
      fmt::format("source: the opposite sign of the height of {} (up is positive){}", name,
                  is_named ? "" : fmt::format("; or sensors.{}.base_T_sensor, the sign of its forward axis", imu.name)),
      0.0);
}

/// Heights against the slopes that gravity shows.
void judge_climb(Case& c, std::size_t i, const Climb& climb) {
  const ForceFit& forwards = climb.fit;
  if (!(forwards.slope.low > 0.0)) return;
  const double margin = kSigmas * forwards.slope_sigma;
  const bool differs = forwards.slope.low - margin > 1.0 + kScaleTolerance ||
                       forwards.slope.high + margin < 1.0 / (1.0 + kScaleTolerance);
  const double scale = std::sqrt(forwards.slope.low * forwards.slope.high);
  const WatchedSensor& heights = c.sensor(climb.with_heights);
  const std::string& name = heights.name;
  c.comparisons.push_back(
      {"slope", c.sensor(i).name, name, scale, forwards.slope_sigma, forwards.spans, differs ? "differ" : "agree"});
  const double difference = (1.0 - scale) * spread_of(heights.height, c.watch.newest());
  if (!differs || (!heights.is_altimeter() && !exceeds_wander(heights, difference))) return;
  const bool is_feet = std::abs(scale / kFoot - 1.0) < kNearFoot;
  // What flies climbs on no slope: gravity shows it by accident, and by no factor that is known.
  if (measured_way(c.watch) == nullptr && !is_feet) return;
  c.add(Certainty::named, "height", {climb.with_heights},
        fmt::format("its heights climb {:.3g} ± {:.2g} times as much as gravity in {} shows", 1.0 / scale,
                    forwards.slope_sigma / (scale * scale), c.sensor(i).name),
        fmt::format("source: height of {} times {:.4g}{}", name, is_feet ? kFoot : scale, is_feet ? " (feet)" : ""),
        0.0);
}

void check_lean(Case& c, std::size_t i, const ForceFit& forwards, const ForceFit& leftwards) {
  const Eigen::Vector2d lean(forwards.lean, leftwards.lean);
  const double sigma = std::max(forwards.lean_sigma, leftwards.lean_sigma) / kGravity;
  if (!(lean.norm() < kGravity)) return;
  const double angle = std::asin(lean.norm() / kGravity);
  const WatchedSensor& sensor = c.sensor(i);
  c.comparisons.push_back(
      {"lean", sensor.name, "the vertical", angle / kDegree, sigma / kDegree, forwards.spans, "degrees between them"});
  const double sigmas = beyond(angle, kLean, sigma);
  if (sigmas < kSigmas) return;
  const Eigen::Vector3d axis(lean.y() / lean.norm(), -lean.x() / lean.norm(), 0.0);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, axis));
  // Adding 0 makes a 0 of a −0.
  const Eigen::Vector3d rpy = (so3::to_rpy(turn * sensor.T_base_sensor.q) / kDegree).array().round() + 0.0;
  c.add(Certainty::named, "mounting", {i},
        fmt::format("its specific force leans {:.1f} ± {:.1f} degrees from the vertical over the whole way",
                    angle / kDegree, sigma / kDegree),
        fmt::format("sensors.{}.base_T_sensor: roll_deg: {:.0f}, pitch_deg: {:.0f}, yaw_deg: {:.0f} fits", sensor.name,
                    rpy.x(), rpy.y(), rpy.z()),
        sigmas);
}

}  // namespace

bool leans_into_curves(const WatchedSensor& imu, const Track& way, const Track& yaw, double newest) {
  if (rolls_into_curves(imu, way, yaw, newest)) return true;
  const ForceFit forwards = fit_forwards(imu, way, nullptr, newest);
  const ForceFit leftwards = fit_leftwards(imu, way, yaw, newest);
  const bool feels_forwards =
      forwards.is_known && forwards.acceleration - kSigmas * forwards.acceleration_sigma > kSign;
  return feels_forwards && leftwards.is_known && std::abs(leftwards.acceleration) < kSign;
}

void check_climbs(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.trusted_way(c);
  const Observer* yaw = motion.yaw.trusted_track();
  if (way == nullptr || c.is_blamed(way->sensor)) return;
  if (yaw != nullptr && c.is_blamed(yaw->sensor)) yaw = nullptr;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (c.sensor(i).force.samples() < kLeastSamples || c.is_concerned(i)) continue;
    const std::vector<Climb> climbs = climbs_of(c, i, *way->track);
    const bool some_climb = std::ranges::any_of(
        climbs, [](const Climb& climb) { return climb.fit.slope.low - kSigmas * climb.fit.slope_sigma > 0.0; });
    for (const Climb& climb : climbs) {
      judge_climb(c, i, climb);
      judge_fall(c, i, climb, *way, yaw, some_climb);
    }
  }
}

void check_slopes(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.trusted_way(c);
  const Observer* yaw = motion.yaw.trusted_track();
  if (way == nullptr || yaw == nullptr || c.is_blamed(way->sensor) || c.is_blamed(yaw->sensor)) return;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    if (sensor.force.samples() < kLeastSamples || c.is_concerned(i)) continue;
    const std::vector<Climb> climbs = climbs_of(c, i, *way->track);
    const ForceFit forwards =
        !climbs.empty() ? climbs.front().fit : fit_forwards(sensor, *way->track, nullptr, c.watch.newest());
    const ForceFit leftwards = fit_leftwards(sensor, *way->track, *yaw->track, c.watch.newest());
    if (!forwards.is_known || !leftwards.is_known) continue;
    const bool leans = leans_into_curves(sensor, *way->track, *yaw->track, c.watch.newest());
    check_signs(c, i, forwards, leans ? ForceFit{} : leftwards, *way);
    if (!c.is_concerned(i)) check_lean(c, i, forwards, leftwards);
  }
}

}  // namespace waymark::host::diagnosis
