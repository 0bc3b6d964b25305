// SPDX-License-Identifier: Apache-2.0
#include "utm.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <limits>
#include <numbers>

namespace waymark::plot {
namespace {

class Projection {
 public:
  explicit Projection(const Origin& origin) : local_(origin.latitude_deg, origin.longitude_deg) {
    double convergence_deg = 0.0;
    GeographicLib::UTMUPS::Forward(origin.latitude_deg, origin.longitude_deg, zone_, is_north_, origin_.x(),
                                   origin_.y(), convergence_deg, scale_);
    // A bearing counts from true north, a grid bearing from the grid's: less by the convergence.
    turn_rad_ = convergence_deg * std::numbers::pi / 180.0;
  }

  Eigen::Vector2d point(const Eigen::Vector2d& p_map) const {
    if (!p_map.allFinite()) return p_map;
    double latitude = 0.0;
    double longitude = 0.0;
    double height = 0.0;
    local_.Reverse(p_map.x(), p_map.y(), 0.0, latitude, longitude, height);
    Eigen::Vector2d p;
    int zone = 0;
    bool is_north = false;
    GeographicLib::UTMUPS::Forward(latitude, longitude, zone, is_north, p.x(), p.y(), zone_);
    return p - origin_;
  }
  Eigen::Matrix2d covariance(const Eigen::Matrix2d& P) const {
    const Eigen::Matrix2d J = scale_ * Eigen::Rotation2Dd(turn_rad_).toRotationMatrix();
    return J * P * J.transpose();
  }
  Pose pose(const Pose& T_map) const {
    const Eigen::Vector2d p = point(T_map.p.head<2>());
    return Pose::planar(p.x(), p.y(), T_map.yaw() + turn_rad_);
  }
  Axes axes() const { return {fmt::format("UTM {}{} east [m]", zone_, is_north_ ? "N" : "S"), "north [m]", origin_}; }

 private:
  GeographicLib::LocalCartesian local_;
  int zone_ = 0;
  bool is_north_ = true;
  Eigen::Vector2d origin_{0.0, 0.0};
  double scale_ = 1.0;
  double turn_rad_ = 0.0;
};

}  // namespace

void to_utm(Content& content, const Origin& origin) {
  const Projection utm(origin);
  for (auto* points : {&content.online, &content.gnss_fused, &content.gnss_rejected, &content.gnss_held_out}) {
    for (Eigen::Vector2d& p : *points) p = utm.point(p);
  }
  for (Content::PositionBelief& belief : content.uncertainty)
    belief = {utm.point(belief.position), utm.covariance(belief.P)};
  if (content.reference) {
    auto reference = std::make_shared<Reference>(*content.reference);
    for (Reference::Point& point : reference->trajectory) point.T_map_base = utm.pose(point.T_map_base);
    for (Reference::Landmark& landmark : reference->landmarks) landmark.p_map = utm.point(landmark.p_map);
    content.reference = reference;
  }
  if (content.end) {
    Content::End& end = *content.end;
    end.T_map_base = utm.pose(end.T_map_base);
    end.P.topLeftCorner<2, 2>() = utm.covariance(end.P.topLeftCorner<2, 2>());
    for (ParticleView& particle : end.particles) particle.T_map_base = utm.pose(particle.T_map_base);
    for (StampedPose& node : end.best_path) node.T_map_base = utm.pose(node.T_map_base);
    for (MapDescription& map : end.maps) {
      if (map.grid) map.grid->T_map_grid = utm.pose(map.grid->T_map_grid);
      if (map.mixture) map.mixture->T_map_grid = utm.pose(map.mixture->T_map_grid);
      for (LandmarkView& landmark : map.landmarks) {
        landmark.p_map = utm.point(landmark.p_map);
        landmark.P.topLeftCorner<2, 2>() = utm.covariance(landmark.P.topLeftCorner<2, 2>());
      }
    }
  }
  content.axes = utm.axes();
}

}  // namespace waymark::plot
