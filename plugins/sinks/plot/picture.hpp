// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/interface/snapshot.hpp"

namespace waymark::plot {

/// Settings of the picture in the YAML.
struct Style {
  enum class Labels { automatic, on, off };
  int width_px = 1600;
  int height_px = 1200;
  Labels landmark_labels = Labels::automatic;
  double sigma = 3.0;         ///< of every ellipse
  bool ellipses = true;       ///< of the estimate along the way
  bool disagreement = false;  ///< dense maps of all particles together: where they differ is coloured
  /// The part that is shown, in the picture's axes, counted from the map's origin [m]; absent: everything.
  struct Window {
    Eigen::Vector2d low;
    Eigen::Vector2d high;
  };
  std::optional<Window> window;
};

/// What the numbers on the axes are.
struct Axes {
  std::string east = "east [m]";
  std::string north = "north [m]";
  Eigen::Vector2d origin{0.0, 0.0};  ///< the numbers at the map's origin
};

/// What there is to draw, map frame [m].
struct Content {
  std::shared_ptr<const Reference> reference;  ///< may be null
  std::vector<Eigen::Vector2d> online;         ///< estimates in the order of their stamps
  /// The mixture's position with its covariance [m²].
  struct PositionBelief {
    Eigen::Vector2d position;
    Eigen::Matrix2d P;
  };
  std::vector<PositionBelief> uncertainty;  ///< along the way
  std::vector<Eigen::Vector2d> gnss_fused;
  std::vector<Eigen::Vector2d> gnss_rejected;  ///< by the gate
  std::vector<Eigen::Vector2d> gnss_held_out;
  std::size_t gnss_fused_count = 0;  ///< before thinning
  std::size_t gnss_rejected_count = 0;
  std::size_t gnss_held_out_count = 0;
  Axes axes;
  std::string name;                   ///< of the run; may be empty
  bool reference_is_aligned = false;  ///< the reference had a frame of its own and was moved
  Time log_start{};
  double log_duration_s = 0.0;
  bool interrupted = false;

  /// The end of the run; absent if the filter never started.
  struct End {
    Pose T_map_base;
    Eigen::Matrix3d P = Eigen::Matrix3d::Zero();  ///< of x, y, yaw
    std::vector<ParticleView> particles;
    std::vector<StampedPose> best_path;
    std::vector<MapDescription> maps;
  };
  std::optional<End> end;
};

/// The picture as a PNG file: the same content gives the same bytes.
std::string draw(const Content& content, const Style& style);

}  // namespace waymark::plot
