// SPDX-License-Identifier: Apache-2.0
#include "planar_cut.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace waymark::kitti {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

}  // namespace

PlanarCut::PlanarCut(const Config& config, const Pose& T_base_sensor)
    : start_(kDegree * config.number_in({"start_deg", "°", "first beam, counter-clockwise from the scanner's x axis"},
                                        -360.0, 360.0, -180.0)),
      step_(kDegree * config.number_in({"step_deg", "°", "from beam to beam, counter-clockwise"}, 0.01, 90.0, 0.2)),
      beams_(static_cast<int>(config.integer_in({"beams", "", "number of beams", "a turn"}, 1, 36'000,
                                                std::lround(std::floor(kTurn / step_ + 1e-9))))),
      range_min_(config.non_negative({"range_min_m", "m", "nearer points are left out; horizontal"}, 2.0)),
      range_max_(config.positive({"range_max_m", "m",
                                  "farther points are left out; horizontal. A beam without a point shows this + 1: "
                                  "that is the `no_return_m` for a map module"},
                                 100.0)),
      sensor_height_(T_base_sensor.p.z()) {
  const std::vector<double> height =
      config.numbers({"height_m", "m", "lowest, highest point of the cut, in the **base's** frame"}, 2);
  height_low_ = height[0];
  height_high_ = height[1];
  if (!(height_low_ < height_high_)) config.fail("height_m", "the lower bound first, then the upper one, are expected");
  if (beams_ * step_ > kTurn * (1.0 + 1e-9)) {
    config.fail("beams", fmt::format("{} beams of {:g} deg are more than a turn", beams_, step_ / kDegree));
  }
  if (range_min_ >= range_max_) config.fail("range_min_m", "must be < range_max_m");
  const double yaw = T_base_sensor.yaw();
  R_level_sensor_ = (so3::from_rpy(0.0, 0.0, -yaw) * T_base_sensor.q).toRotationMatrix();
}

PlanarCut::Result PlanarCut::operator()(std::span<const float> points) const {
  Result result;
  result.scan = std::make_shared<LaserScan>();
  LaserScan& scan = *result.scan;
  scan.start_rad = start_;
  scan.step_rad = step_;
  scan.ranges_m.assign(static_cast<std::size_t>(beams_), static_cast<float>(no_return_m()));
  scan.intensities.assign(static_cast<std::size_t>(beams_), 0.0f);
  for (std::size_t i = 0; i + 4 <= points.size(); i += 4) {
    const Eigen::Vector3d p_sensor(points[i], points[i + 1], points[i + 2]);
    if (!p_sensor.allFinite() || !std::isfinite(points[i + 3])) {
      ++result.not_finite;
      continue;
    }
    const Eigen::Vector3d p = R_level_sensor_ * p_sensor;
    const double height = p.z() + sensor_height_;
    if (height < height_low_ || height > height_high_) continue;
    const double range = p.head<2>().norm();
    if (range < range_min_ || range > range_max_) continue;
    // Beam k is the middle of its bin.
    double from_start = std::fmod(std::atan2(p.y(), p.x()) - start_ + 0.5 * step_, kTurn);
    if (from_start < 0.0) from_start += kTurn;
    const auto beam = static_cast<std::size_t>(from_start / step_);
    if (beam >= scan.ranges_m.size() || range >= static_cast<double>(scan.ranges_m[beam])) continue;
    scan.ranges_m[beam] = static_cast<float>(range);
    scan.intensities[beam] = points[i + 3];
  }
  return result;
}

}  // namespace waymark::kitti
