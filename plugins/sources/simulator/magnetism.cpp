// SPDX-License-Identifier: Apache-2.0
#include "magnetism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr double kFieldConstant = 1e-7;  // µ0 / 4π [T·m/A]
constexpr double kListedNearest = 0.2;   // [m], size of a disturber that is not a landmark

/// A direction uniform on the sphere, of disturber `index`.
Eigen::Vector3d random_direction(std::uint64_t seed, std::size_t index) {
  Random random = stream(seed, Draw::metal, Duration{static_cast<std::int64_t>(index)});
  const double z = 2.0 * random.uniform() - 1.0;
  const double azimuth = 2.0 * std::numbers::pi * random.uniform();
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

}  // namespace

Magnetism::Magnetism(const Config& config, const World& world, std::uint64_t seed)
    : disturbances_(
          config,
          {"disturbances_s", "s",
           "begin, end of spans with one more constant field: a motor's current, a steel plate under the robot"}) {
  const std::vector<double> earth = config.numbers(
      {"earth_field_t", "T", "east, north, up; declination is atan2(east, north)"}, 3, {0.0, 2.0e-5, -4.4e-5});
  earth_field_t_ = Eigen::Vector3d::Map(earth.data());
  const double horizontal = earth_field_t_.head<2>().norm();
  if (!(horizontal > 1e-7 && earth_field_t_.norm() < 1e-3)) {
    config.fail("earth_field_t", "about 5e-5 T is expected: east, north, up, with a horizontal part");
  }
  const double moment = config.non_negative(
      {"metal_moment_am2", "A·m²", "dipole moment of a metal landmark, in a random direction"}, 20.0);
  for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
    const Cylinder& landmark = world.landmarks[i];
    if (!world.metal[landmark.texture]) continue;
    disturbers_.push_back({landmark.center, landmark.radius_m, moment * random_direction(seed, i)});
  }
  const std::vector<double> listed = config.numbers(
      {"disturbers", "m, m, A·m²", "x, y, moment of one more dipole after the other, one flat list"}, -1, {});
  if (listed.size() % 3 != 0) {
    config.fail("disturbers",
                fmt::format("{} numbers; x [m], y [m], moment [A·m²] of each disturber are expected", listed.size()));
  }
  for (std::size_t i = 0; i < listed.size(); i += 3) {
    const std::size_t number = world.landmarks.size() + i / 3;
    disturbers_.push_back({{listed[i], listed[i + 1]}, kListedNearest, listed[i + 2] * random_direction(seed, number)});
  }
  disturbance_t_ = Eigen::Vector3d::Map(
      config.numbers({"disturbance_t", "T", "the field of `disturbances_s`"}, 3, {2.0e-5, 1.0e-5, 0.0}).data());
  disturbance_of_robot_ =
      config.choice({"disturbance_frame", "`base`: that field turns with the robot; `map`: it does not"},
                    {"base", "map"}, "base") == "base";
  if (!(disturbance_t_.norm() < 1e-2)) config.fail("disturbance_t", "less than 1e-2 T is expected");
}

Eigen::Vector3d Magnetism::field(const Eigen::Vector3d& p_map, const Eigen::Quaterniond& q_map_base,
                                 Duration time) const {
  Eigen::Vector3d field = earth_field_t_;
  for (const Disturber& disturber : disturbers_) {
    // The dipole is as high as the sensor: metal that stands there is magnetic all along.
    Eigen::Vector3d r = Eigen::Vector3d::Zero();
    r.head<2>() = p_map.head<2>() - disturber.p_map;
    const double distance = std::max(r.norm(), disturber.nearest_m);
    const Eigen::Vector3d direction = r / distance;
    field += kFieldConstant / (distance * distance * distance) *
             (3.0 * disturber.moment_am2.dot(direction) * direction - disturber.moment_am2);
  }
  if (disturbances_.contain(time)) {
    field += disturbance_of_robot_ ? Eigen::Vector3d(q_map_base * disturbance_t_) : disturbance_t_;
  }
  return field;
}

}  // namespace waymark::simulator
