// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "checks.hpp"
#include "field_turns.hpp"
#include "fit.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kStep = 0.5;        // [s]
constexpr double kHalfWindow = 0.2;  // [s], for a rate at a time
constexpr double kSteady = 0.3;      // [m/s²], more takes the vertical away by degrees, and the heading with it
constexpr double kSigmas = 5.0;
constexpr std::size_t kOctants = 8;
constexpr std::size_t kLeastOctants = 6;       // in which a heading was, or harmonics look like a bias
constexpr double kUpright = 0.95;              // mean cosine of the tilt: 18°
constexpr double kNoiseTimes = 6.0;            // as large as the σ that is given
constexpr double kLeastNoise = 0.5 * kDegree;  // of the heading itself; the gyro has some of its own
constexpr long kLeastSamples = 100;

/// The compass's deviation: what its heading is off at the heading ψ, B sin ψ + C cos ψ (its robot's magnets) and
/// D sin 2ψ + E cos 2ψ (soft iron, an axis with another scale) (A. Smith, 1851).
struct Deviation {
  double once = 0.0;  ///< largest value of what changes once per turn [rad]
  double once_sigma = 0.0;
  double twice = 0.0;
  double twice_sigma = 0.0;
  double noise = 0.0;  ///< white, of one heading [rad]
};

/// True if the robot neither curves nor brakes so much that a heading out of field and specific force suffers. `way`:
/// null if nothing measures it.
bool is_steady(const Track* way, const Track& gyro, double t) {
  if (way == nullptr) return true;
  const auto before = way->rate(t - kHalfWindow, kHalfWindow);
  const auto after = way->rate(t + kHalfWindow, kHalfWindow);
  const auto turn = gyro.rate(t, kHalfWindow);
  if (!before || !after || !turn) return false;
  const double sideways = 0.5 * (*before + *after) * *turn;
  const double forwards = (*after - *before) / (2.0 * kHalfWindow);
  return std::hypot(sideways, forwards) < kSteady;
}

/// A heading less the angle that the gyro has turned, and that angle.
struct Sample {
  double t;
  double difference;
  double turned;
  bool begins_stretch;  ///< what was turned before is not known
};

std::vector<Sample> samples_of(const Track& heading, const Track& gyro, const Track* way, double newest) {
  std::vector<Sample> samples;
  bool is_new = true;
  double last = 0.0;
  for (double t = 0.0; t <= newest; t += kStep) {
    if (!gyro.change(last, t) || !heading.change(last, t)) is_new = true;
    last = t;
    const auto seen = heading.at(t);
    const auto turned = gyro.at(t);
    if (!seen || !turned || !is_steady(way, gyro, t)) continue;
    // In a curve the heading may be so wrong that its track misses a whole turn.
    const double before = is_new ? 0.0 : samples.back().difference;
    samples.push_back({t, before + so3::wrap(*seen - *turned - before), *turned, is_new});
    is_new = false;
  }
  return samples;
}

/// Where a stretch begins nobody knows the angle: its rows count about their means.
void center(Rows& rows, Eigen::Index from) {
  const Eigen::Index count = rows.count - from;
  if (count == 0) return;
  auto block = rows.A.middleRows(from, count);
  block.rowwise() -= block.colwise().mean().eval();
  auto values = rows.y.segment(from, count);
  values.array() -= values.mean();
}

/// Rows of heading less angle turned: the gyro's bias, and with `bias` given the deviation.
Fit fit_deviation(const std::vector<Sample>& samples, const double* bias) {
  Rows rows(static_cast<Eigen::Index>(samples.size()), bias != nullptr ? 5 : 1);
  Eigen::Index stretch = 0;
  for (const Sample& sample : samples) {
    if (sample.begins_stretch) {
      center(rows, stretch);
      stretch = rows.count;
    }
    rows.A(rows.count, 0) = sample.t;
    if (bias != nullptr) {
      // The true heading but for a constant, which changes the phases alone.
      const double heading = sample.turned + *bias * sample.t;
      rows.A.row(rows.count).tail<4>() << std::sin(heading), std::cos(heading), std::sin(2.0 * heading),
          std::cos(2.0 * heading);
    }
    rows.y(rows.count++) = sample.difference;
  }
  center(rows, stretch);
  return fit_rows(rows);
}

/// Eighths of a turn in which the robot was headed.
std::size_t octants_of(const std::vector<Sample>& samples, double bias) {
  std::bitset<kOctants> octants;
  for (const Sample& sample : samples) {
    const double share = so3::wrap(sample.turned + bias * sample.t) / (2.0 * std::numbers::pi) + 0.5;
    octants.set(std::min(kOctants - 1, static_cast<std::size_t>(share * kOctants)));
  }
  return octants.count();
}

/// From the heading less the angle that the gyro has turned, at times when the robot is steady.
std::optional<Deviation> deviation_of(const Track& heading, const Track& gyro, const Track* way, double newest) {
  const std::vector<Sample> samples = samples_of(heading, gyro, way, newest);
  const Fit line = fit_deviation(samples, nullptr);
  if (!line.valid || octants_of(samples, line.x(0)) < kLeastOctants) return std::nullopt;
  const Fit fit = fit_deviation(samples, &line.x(0));
  if (!fit.valid) return std::nullopt;
  return Deviation{std::hypot(fit.x(1), fit.x(2)), std::max(fit.sigma(1), fit.sigma(2)), std::hypot(fit.x(3), fit.x(4)),
                   std::max(fit.sigma(3), fit.sigma(4)), fit.residual};
}

/// True if its z axis points up nearly always, so that turns about it are turns of the heading.
bool stays_upright(const WatchedSensor& imu) {
  if (imu.force_count == 0) return true;
  return imu.force_sum.z() / static_cast<double>(imu.force_count) > kUpright * imu.forces.quantile(0.5);
}

/// The gyro to which a heading is compared: its own IMU's, or that of another sensor.
std::optional<std::size_t> gyro_for(const Case& c, std::size_t i) {
  if (c.sensor(i).heading.samples() > 0) return i;
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    const WatchedSensor& sensor = c.sensor(k);
    const bool is_gyro = sensor.role() == Role::gyro || sensor.heading.samples() > 0;
    if (k != i && is_gyro && sensor.yaw.samples() >= kLeastSamples && !c.is_concerned(k)) return k;
  }
  return std::nullopt;
}

/// True if the field itself shows that it is not iron: a robot that flies tilted, or leans, tilts its compass, too, and
/// that turns with it.
bool is_no_iron(const Case& c, std::size_t i, std::size_t gyro, double deviation) {
  constexpr double kHalf = 0.5;
  const WatchedSensor& sensor = c.sensor(i);
  const auto iron = iron_of(sensor, c.sensor(gyro), c.watch.newest());
  if (!iron) return false;
  std::vector<double> level;
  for (double t = kHalfWindow; t + kHalfWindow < c.watch.newest(); t += kStep) {
    if (const auto field = sensor.field.rate(t, kHalfWindow)) level.push_back(field->head<2>().norm());
  }
  return iron->value + kSigmas * iron->sigma < kHalf * deviation * median(level);
}

void add_deviation(Case& c, std::size_t i, const std::string& gyro, double value, double sigma, bool is_twice) {
  const WatchedSensor& sensor = c.sensor(i);
  const double sigmas = beyond(value, heading_tolerance(sensor), sigma);
  if (sigmas < kSigmas) return;
  std::string change = fmt::format("another place for {}, away from iron and motors", sensor.name);
  if (sensor.usual.m_base.allFinite())
    change = fmt::format("sensors.{}.{}: `waymark calibrate` measures it, or {}", sensor.name,
                         is_twice ? "soft_iron" : "hard_iron_t", change);
  c.add(Certainty::named, "deviation", {i},
        fmt::format("its heading is off by up to {:.0f} ± {:.1f} degrees to either side, {} per turn of the robot, "
                    "against the turns of {}",
                    value / kDegree, sigma / kDegree, is_twice ? "twice" : "once", gyro),
        change, sigmas);
}

void check_heading_noise(Case& c, std::size_t i, const std::string& gyro, double noise) {
  const double given = c.setting(i, "sigma_deg") * kDegree;
  if (!(given > 0.0) || noise < std::max(kNoiseTimes * given, kLeastNoise)) return;
  c.add(Certainty::named, "noise", {i},
        fmt::format("its heading scatters by {:.2g} degrees against the turns of {}, {:.0f} times its sigma of {:.2g} "
                    "degrees",
                    noise / kDegree, gyro, noise / given, given / kDegree),
        fmt::format("sensors.{}.sigma_deg: {:.2g} fits", c.sensor(i).name, noise / kDegree), 0.0);
}

}  // namespace

void check_deviations(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.way.trusted_track();
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    const Track& heading = sensor.has_heading ? sensor.yaw : sensor.heading;
    if (heading.samples() < kLeastSamples || c.is_concerned(i)) continue;
    const auto gyro = gyro_for(c, i);
    if (!gyro || !stays_upright(c.sensor(*gyro))) continue;
    const auto deviation =
        deviation_of(heading, c.sensor(*gyro).yaw, way != nullptr ? way->track : nullptr, c.watch.newest());
    if (!deviation || is_no_iron(c, i, *gyro, deviation->once)) continue;
    const std::string name = *gyro == i ? "its own gyro" : c.sensor(*gyro).name;
    c.comparisons.push_back({"deviation", sensor.name, name, deviation->once / kDegree, deviation->once_sigma / kDegree,
                             0, "degrees, once per turn"});
    add_deviation(c, i, name, deviation->once, deviation->once_sigma, false);
    if (!c.is_concerned(i)) add_deviation(c, i, name, deviation->twice, deviation->twice_sigma, true);
    if (!c.is_concerned(i)) check_heading_noise(c, i, name, deviation->noise);
  }
}

}  // namespace waymark::host::diagnosis
