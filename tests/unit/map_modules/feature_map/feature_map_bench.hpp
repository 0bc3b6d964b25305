// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "map_modules/feature_map/extraction/cylinder_extraction.hpp"
#include "map_modules/feature_map/particle_feature_map.hpp"
#include "waymark/interface/payloads.hpp"

/// Worlds, scans and landmarks for the tests of the feature map.
namespace waymark::feature_map_test {

using namespace waymark::feature_map;

inline constexpr double kDegree = std::numbers::pi / 180.0;

inline FeatureMapSettings settings_of(const std::string& yaml) {
  const Config config = Config::parse(yaml);
  const FeatureMapSettings settings = FeatureMapSettings::read(config);
  config.reject_unread();
  return settings;
}

/// What stands around a scanner, in the scanner's frame [m].
struct World {
  struct Cylinder {
    Eigen::Vector2d center;
    double radius;
  };
  struct Wall {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
  };
  std::vector<Cylinder> cylinders;
  std::vector<Wall> walls;

  /// Distance to the first surface at `bearing`, or infinity.
  double cast(double bearing) const {
    const Eigen::Vector2d beam(std::cos(bearing), std::sin(bearing));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Cylinder& c : cylinders) {
      const double along = beam.dot(c.center);
      const double square = c.radius * c.radius - (c.center.squaredNorm() - along * along);
      if (square >= 0.0 && along > 0.0) nearest = std::min(nearest, along - std::sqrt(square));
    }
    for (const Wall& w : walls) {
      Eigen::Matrix2d A;
      A << beam, w.from - w.to;
      if (std::abs(A.determinant()) < 1e-12) continue;
      const Eigen::Vector2d solution = A.inverse() * w.from;
      if (solution.x() > 0.0 && solution.y() >= 0.0 && solution.y() <= 1.0) nearest = std::min(nearest, solution.x());
    }
    return nearest;
  }
};

/// Half a turn in steps of half a degree, as many scanners give it; 81 m where nothing is within 60 m.
inline LaserScan scan_of(const World& world) {
  LaserScan scan;
  scan.start_rad = -90.0 * kDegree;
  scan.step_rad = 0.5 * kDegree;
  for (int k = 0; k <= 360; ++k) {
    const double range = world.cast(scan.start_rad + k * scan.step_rad);
    scan.ranges_m.push_back(range < 60.0 ? static_cast<float>(range) : 81.0f);
  }
  return scan;
}

/// A detection of a landmark at `p_map`, as seen without error from `pose` (x, y, yaw).
inline Detection detection_of(const Eigen::Vector2d& p_map, const Eigen::Vector3d& pose, double sigma = 0.05,
                              double radius = 0.2) {
  Detection detection;
  detection.xyr.head<2>() = Eigen::Rotation2Dd(-pose.z()) * (p_map - pose.head<2>());
  detection.xyr.z() = radius;
  detection.R = sigma * sigma * Eigen::Matrix3d::Identity();
  detection.R(0, 1) = detection.R(1, 0) = 0.3 * sigma * sigma;
  detection.signature = {0.5f, 0.5f};
  return detection;
}

inline FeatureObservation observation_of(std::vector<Detection> detections) {
  FeatureObservation observation;
  observation.detections = std::move(detections);
  for (const Detection& d : observation.detections)
    observation.max_range = std::max(observation.max_range, d.xyr.head<2>().norm());
  return observation;
}

/// A landmark that has been seen often.
inline Landmark landmark_at(double east, double north, double sigma = 0.05, double radius = 0.2) {
  Landmark landmark;
  landmark.mean = {east, north, radius};
  landmark.P = sigma * sigma * Eigen::Matrix3d::Identity();
  landmark.signature = {0.5f, 0.5f};
  landmark.sightings = 10;
  landmark.log_odds = 3.0f;
  return landmark;
}

inline PoseGaussian gaussian_at(const Eigen::Vector3d& pose, const Eigen::Matrix3d& P) {
  return {Pose::planar(pose.x(), pose.y(), pose.z()), P};
}

/// One mapping step: refine, then insert with covariance `kept`.
inline Refinement step(ParticleFeatureMap& map, const Eigen::Vector3d& pose, const Eigen::Matrix3d& prior,
                       const Eigen::Matrix3d& kept, const FeatureObservation& observation) {
  Refinement refinement;
  map.refine(gaussian_at(pose, prior), Pose::planar(pose.x(), pose.y(), pose.z()), observation, refinement);
  map.insert(gaussian_at(pose, kept), observation, refinement.association.get());
  return refinement;
}

}  // namespace waymark::feature_map_test
