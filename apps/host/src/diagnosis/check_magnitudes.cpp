// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kMostSpeed = 90.0;    // [m/s], of a robot on the ground
constexpr double kMostRate = 36.0;     // [rad/s], 2000 °/s: the range of a common gyro
constexpr double kLeastField = 15e-6;  // [T], the Earth's has 22 to 67 µT
constexpr double kMostField = 100e-6;
constexpr double kFarDatum = 50e3;        // [m], no robot's map reaches so far, and the Earth is no plane there
constexpr double kEarthRadius = 6.371e6;  // [m]
constexpr std::size_t kLeastValues = 30;
constexpr std::size_t kLeastStamps = 8;
constexpr double kMostTurns = 4.0 * std::numbers::pi;  // [rad], of an angle that is not in degrees
constexpr double kNearRoom = 0.75;                     // [m], half of the ranges of few rooms are shorter
constexpr double kStill = 1e-7;                        // [rad/s], no gyro is so quiet
constexpr double kTurning = 0.05;                      // [rad/s]
constexpr double kOverturned = 90.0 * kDegree;         // of any robot that is not held in any way
constexpr double kTilted = 40.0 * kDegree;             // of a robot in the plane

/// A factor and what is multiplied by it by mistake.
struct Unit {
  double factor;
  std::string_view name;
};

/// The unit of a value that should lie in [low, high]; nothing if none fits.
template <std::size_t N>
std::optional<Unit> unit_of(double value, double low, double high, const std::array<Unit, N>& units) {
  for (const Unit& unit : units) {
    if (value * unit.factor >= low && value * unit.factor <= high) return unit;
  }
  return std::nullopt;
}

/// Usual times between two measurements [s].
std::pair<double, double> usual_interval(const WatchedSensor& sensor) {
  // Milliseconds taken for seconds make a period of 1 s of the shortest ones.
  if (sensor.payload == ImuSample::kType) return {1e-4, 0.95};
  if (sensor.payload == LaserScan::kType || sensor.payload == PointCloud::kType) return {0.005, 5.0};
  if (sensor.payload == GnssFix::kType) return {0.01, 60.0};
  if (sensor.payload == WheelSpeeds::kType || sensor.payload == BodyTwist::kType ||
      sensor.payload == WheelSteering::kType)
    return {1e-4, 3.0};
  return {1e-5, 100.0};
}

void check_stamps(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.intervals.size() < kLeastStamps) return;
  const double usual = sensor.intervals.quantile(0.5);
  if (const double sweep = sensor.sweeps.size() > 0 ? sensor.sweeps.quantile(0.5) : 0.0; sweep > 1.5 * usual) {
    c.add(Certainty::named, "stamps", {i},
          fmt::format("the beams of a scan take {:.3g} s, and scans come every {:.3g} s", sweep, usual),
          fmt::format("source: beam_interval_s of {} divided by {:.3g} or more", sensor.name, sweep / usual), 0.0);
  }
  const auto [low, high] = usual_interval(sensor);
  if (usual <= 0.0 || (usual >= low && usual <= high)) return;
  static constexpr std::array<Unit, 6> kUnits{{{1e-3, "milliseconds taken for seconds"},
                                               {1e-6, "microseconds taken for seconds"},
                                               {1e-9, "nanoseconds taken for seconds"},
                                               {1e3, "seconds taken for milliseconds"},
                                               {1e6, "seconds taken for microseconds"},
                                               {1e9, "seconds taken for nanoseconds"}}};
  const auto unit = unit_of(usual, low, high, kUnits);
  if (!unit) return;
  c.add(Certainty::named, "stamps", {i},
        fmt::format("{:.3g} s from one measurement to the next: {}", usual, unit->name),
        fmt::format("source: time of {} times {:g}", sensor.name, unit->factor), 0.0);
}

void check_speed(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  const double speed = sensor.speeds.quantile(0.9);
  const double rate = sensor.rates.quantile(0.9);
  if (sensor.speeds.size() >= kLeastValues && speed > kMostSpeed) {
    c.add(Certainty::named, "unit", {i},
          fmt::format("speeds up to {:.0f} m/s; more than {:.0f} m/s is no robot on the ground", speed, kMostSpeed),
          fmt::format("source: speeds of {} in m/s (mm/s: scale 0.001)", sensor.name), 0.0);
    return;
  }
  if (sensor.rates.size() >= kLeastValues && rate > kMostRate) {
    c.add(Certainty::named, "unit", {i}, fmt::format("turns by {:.0f} rad/s", rate),
          fmt::format("source: rates of {} in rad/s (deg/s: scale {:.6f})", sensor.name, kDegree), 0.0);
  }
}

void check_force(Case& c, std::size_t i) {
  constexpr double kLeastGravity = 0.93 * kGravity;
  constexpr double kMostGravity = 1.07 * kGravity;
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.forces.size() < kLeastValues) return;
  const double force = sensor.forces.quantile(0.5);
  static constexpr std::array<Unit, 7> kUnits{{{1.0, ""},
                                               {kGravity, "g"},
                                               {kGravity * 1e-3, "mg"},
                                               {0.01, "cm/s²"},
                                               {1e-3, "mm/s²"},
                                               {1.0 / kGravity, "m/s² that were taken for g"},
                                               {0.3048, "ft/s²"}}};
  const auto unit = unit_of(force, kLeastGravity, kMostGravity, kUnits);
  const Eigen::Vector3d up = sensor.force_sum / static_cast<double>(sensor.force_count);
  // Where a machine shakes, single magnitudes are larger than that of the mean.
  const bool is_shaken = up.norm() > kLeastGravity && up.norm() < kMostGravity;
  if (!is_shaken && (!unit || unit->factor != 1.0)) {
    c.add(Certainty::named, "gravity", {i},
          fmt::format("a specific force of {:.4g} m/s² where gravity is {:.2f}{}", force, kGravity,
                      unit ? fmt::format(": it is in {}", unit->name) : ""),
          fmt::format("source: f_x_mps2, f_y_mps2, f_z_mps2 of {} times {:.5g}", sensor.name,
                      unit ? unit->factor : kGravity / force),
          0.0);
    if (!unit) return;
  }
  // A robot in space stands on its wheels more often than on its head, unless the YAML says that it is held in any way.
  const bool is_planar = c.robot.settings.motion == StateLayout::Motion::planar;
  const double most = is_planar ? kTilted : kOverturned;
  if (!is_planar && c.setting(i, "max_mounting_tilt_deg") * kDegree > kOverturned) return;
  if (up.norm() < 0.5 * force) return;  // it is held in any way
  const double tilt = std::atan2(up.head<2>().norm(), up.z());
  if (tilt < most) return;
  const Eigen::Vector3d up_sensor = sensor.T_base_sensor.q.conjugate() * up;
  Eigen::Index axis = 0;
  up_sensor.cwiseAbs().maxCoeff(&axis);
  const bool is_negative = up_sensor(axis) < 0.0;
  static constexpr std::array<std::string_view, 6> kFits{"pitch_deg: -90",  // +x up
                                                         "roll_deg: 90",    // +y up
                                                         "roll_deg: 0",     // +z up
                                                         "pitch_deg: 90",  "roll_deg: -90", "roll_deg: 180"};
  // The other angle, where it is not 0 already.
  const Eigen::Vector3d rpy = so3::to_rpy(sensor.T_base_sensor.q);
  const bool is_other_zero = std::abs(axis == 0 ? std::sin(rpy.x()) : std::sin(rpy.y())) < 0.1;
  const std::string_view other = is_other_zero ? "" : axis == 0 ? ", roll_deg: 0" : ", pitch_deg: 0";
  c.add(Certainty::named, "gravity", {i},
        fmt::format("up is {:.0f} degrees from the z axis of the base: gravity points along {}{} of the sensor",
                    tilt / kDegree, is_negative ? "+" : "-", "xyz"[axis]),
        fmt::format("sensors.{}.base_T_sensor.{}{} fits, or the opposite sign of its specific force", sensor.name,
                    kFits[static_cast<std::size_t>(axis + (is_negative ? 3 : 0))], other),
        0.0);
}

void check_field(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.fields.size() < kLeastValues) return;
  const double field = sensor.fields.quantile(0.5);
  if (field >= kLeastField && field <= kMostField) return;
  static constexpr std::array<Unit, 5> kUnits{
      {{1e-6, "µT"}, {1e-9, "nT"}, {1e-4, "gauss"}, {1e-7, "milligauss"}, {1e6, "T that were taken for µT"}}};
  const auto unit = unit_of(field, kLeastField, kMostField, kUnits);
  c.add(Certainty::named, "field", {i},
        fmt::format("a magnetic field of {:.3g} T, where the Earth's has 22 to 67 µT{}", field,
                    unit ? fmt::format(": it is in {}", unit->name) : ""),
        fmt::format("source: m_x_t, m_y_t, m_z_t of {} times {:.3g}", sensor.name, unit ? unit->factor : 48e-6 / field),
        0.0);
}

/// How far others turn within 10 s beyond what they turn always (the rest value of a gyro), in the third of these in
/// which it is most, by the one that turns least: one may be wrong by itself [rad]. Nothing if nobody measures it.
std::optional<double> turned_by_others(const Case& c, std::size_t except) {
  constexpr double kSpan = 10.0;  // [s]
  constexpr std::size_t kLeastSpans = 6;
  std::optional<double> least;
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    if (k == except) continue;
    for (const Track* track : {&c.sensor(k).yaw, &c.sensor(k).course}) {
      std::vector<double> turns;
      for (double t = 0.0; t + kSpan <= c.watch.newest(); t += kSpan) {
        if (const auto turned = track->change(t, t + kSpan)) turns.push_back(*turned);
      }
      if (turns.size() < kLeastSpans) continue;
      const double always = median(turns);
      for (double& turn : turns) turn = std::abs(turn - always);
      std::ranges::sort(turns, std::greater());
      const double turned = turns[turns.size() / 3];
      least = std::min(least.value_or(turned), turned);
    }
  }
  return least;
}

/// A heading in radians that is taken for degrees: it stays within a few degrees while the robot turns round.
void check_radians(Case& c, std::size_t i) {
  constexpr double kWhole = 2.0 * std::numbers::pi * kDegree;
  constexpr double kMost = 1.01 * kWhole;
  constexpr double kLeast = 0.4 * kWhole;  // of those from −π to π half is reached
  constexpr double kTurned = 4.0 * kWhole;
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.headings.size() < kLeastValues) return;
  const double most = sensor.headings.quantile(1.0);
  const auto turned = turned_by_others(c, i);
  if (most > kMost || most < kLeast || !turned || *turned < kTurned) return;
  c.add(Certainty::named, "unit", {i},
        fmt::format("headings up to {:.2f} degrees, while the others turn by {:.0f} degrees within 10 s: they are in "
                    "radians",
                    most / kDegree, *turned / kDegree),
        fmt::format("source: heading_deg of {} is heading_rad", sensor.name), 0.0);
}

void check_angles(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  const double most = 2.0 * std::numbers::pi + 0.1;
  const auto are_degrees = [&](const Thinned& angles) {
    return angles.size() >= kLeastValues && angles.quantile(0.9) > most && angles.quantile(1.0) > kMostTurns;
  };
  if (are_degrees(sensor.headings)) {
    c.add(Certainty::named, "unit", {i},
          fmt::format("headings up to {:.0f} rad: they are in degrees", sensor.headings.quantile(1.0)),
          fmt::format("source: heading_rad of {} times {:.9f}", sensor.name, kDegree), 0.0);
  }
  if (sensor.steerings.size() >= kLeastValues && sensor.steerings.quantile(0.98) > 0.5 * std::numbers::pi) {
    const double largest = sensor.steerings.quantile(1.0);
    const bool is_wheel_of_driver = largest < kMostTurns;  // which turns some 15 times as far
    c.add(Certainty::named, "unit", {i},
          fmt::format("steers by up to {:.3g} rad: {}", largest,
                      is_wheel_of_driver ? "it is the angle of the steering wheel" : "they are degrees"),
          is_wheel_of_driver
              ? fmt::format("source: steering_rad of {} divided by the ratio of the steering, 12 to 20", sensor.name)
              : fmt::format("source: steering_rad of {} times {:.9f}", sensor.name, kDegree),
          0.0);
  }
  if (are_degrees(sensor.courses)) {
    c.add(Certainty::named, "unit", {i},
          fmt::format("courses up to {:.0f} rad: they are in degrees", sensor.courses.quantile(1.0)),
          fmt::format("source: course_rad of {} times {:.9f}", sensor.name, kDegree), 0.0);
  }
}

void check_ranges(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.ranges.size() < kLeastValues) return;
  const double range = sensor.ranges.quantile(0.5);
  if (range >= 0.02 && range <= 300.0) return;
  static constexpr std::array<Unit, 3> kUnits{{{1e-3, "mm"}, {0.01, "cm"}, {1e3, "m that were taken for mm"}}};
  auto unit = unit_of(range, 0.1, 100.0, kUnits);
  if (unit && range * unit->factor < kNearRoom) unit = unit_of(range, kNearRoom, 100.0, kUnits);
  c.add(Certainty::named, "unit", {i},
        fmt::format("half of its ranges are beyond {:.3g} m{}", range,
                    unit ? fmt::format(": they are in {}", unit->name) : ""),
        fmt::format("source: ranges_m of {} times {:g}", sensor.name, unit ? unit->factor : 1.0), 0.0);
}

/// A gyro whose rate about the vertical is zero while another sensor turns.
void check_still(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.role() != Role::gyro || sensor.rates.size() < kLeastValues || sensor.rates.quantile(1.0) > kStill) return;
  for (const WatchedSensor& other : c.watch.sensors()) {
    if (&other == &sensor || other.rates.size() < kLeastValues || other.rates.quantile(0.9) < kTurning) continue;
    c.add(Certainty::named, "still", {i},
          fmt::format("it never turns about the vertical axis, and {} turns by up to {:.2g} rad/s", other.name,
                      other.rates.quantile(0.9)),
          fmt::format("source: the column of w_z_radps of {}, or sensors.{}.base_T_sensor: another axis points up",
                      sensor.name, sensor.name),
          0.0);
    return;
  }
}

double distance_on_earth(double latitude_a, double longitude_a, double latitude_b, double longitude_b) {
  const double a = kDegree * latitude_a;
  const double b = kDegree * latitude_b;
  const double half_latitude = std::sin(0.5 * (b - a));
  const double half_longitude = std::sin(0.5 * kDegree * (longitude_b - longitude_a));
  const double h = half_latitude * half_latitude + std::cos(a) * std::cos(b) * half_longitude * half_longitude;
  return 2.0 * kEarthRadius * std::asin(std::min(1.0, std::sqrt(h)));
}

void check_place(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (!c.watch.datum_is_given() || std::isnan(sensor.latitude_deg)) return;
  const Datum& datum = *c.watch.datum();
  const double far =
      distance_on_earth(sensor.latitude_deg, sensor.longitude_deg, datum.latitude_deg, datum.longitude_deg);
  if (far < kFarDatum) return;
  const double swapped =
      distance_on_earth(sensor.longitude_deg, sensor.latitude_deg, datum.latitude_deg, datum.longitude_deg);
  const bool fits_swapped = std::abs(sensor.longitude_deg) <= 90.0 && swapped < kFarDatum;
  c.add(Certainty::named, "place", {i},
        fmt::format("latitude {:.4f}, longitude {:.4f} are {:.0f} km from the datum{}", sensor.latitude_deg,
                    sensor.longitude_deg, 1e-3 * far,
                    fits_swapped ? fmt::format(", and {:.1f} km if they are swapped", 1e-3 * swapped) : ""),
        fits_swapped ? fmt::format("source: swap latitude_deg and longitude_deg of {}", sensor.name)
                     : fmt::format("datum: {{ latitude_deg: {:.6f}, longitude_deg: {:.6f} }} is the first fix",
                                   sensor.latitude_deg, sensor.longitude_deg),
        0.0);
}

/// Positions that were rounded on their way, as by a tool that writes few digits.
void check_decimals(Case& c, std::size_t i) {
  constexpr double kRoundingSigma = 0.289;  // of a uniform distribution of width 1
  constexpr double kMostRounding = 2.0;     // by the σ of the positions
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.fixes.size() < kLeastValues || std::isnan(sensor.latitude_deg) || sensor.decimals >= kManyDecimals) return;
  const double sigma = sensor.usual.position_sigma_m;
  const double rounding = kRoundingSigma * kDegree * kEarthRadius * std::pow(10.0, -sensor.decimals);
  if (!(rounding > kMostRounding * sigma)) return;
  c.add(Certainty::named, "rounding", {i},
        fmt::format("latitude and longitude have {} decimals: they are rounded by {:.2g} m (sigma), and positions are "
                    "taken to have {:.2g} m",
                    sensor.decimals, rounding, sigma),
        fmt::format("source: {} with all decimals that the receiver has, or sensors.{}.sigma_m: {:.2g}", sensor.name,
                    sensor.name, rounding),
        0.0);
}

}  // namespace

void check_magnitudes(Case& c) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (!c.sensor(i).is_watched) continue;
    check_stamps(c, i);
    check_speed(c, i);
    check_force(c, i);
    check_field(c, i);
    check_angles(c, i);
    check_radians(c, i);
    check_ranges(c, i);
    check_still(c, i);
    check_place(c, i);
    check_decimals(c, i);
  }
}

}  // namespace waymark::host::diagnosis
