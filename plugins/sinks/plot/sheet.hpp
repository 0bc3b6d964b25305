// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "canvas.hpp"
#include "picture.hpp"

namespace waymark::plot {

inline constexpr Color kInk{45, 52, 60};
inline constexpr Color kSoftInk{125, 133, 142};
inline constexpr Color kGrid{234, 236, 239};
inline constexpr Color kFrame{190, 195, 201};
inline constexpr Color kWhite{255, 255, 255};
inline constexpr Color kEstimate{92, 164, 222};
inline constexpr Color kUncertainty{120, 152, 200};
inline constexpr Color kBestPath{20, 48, 98};
inline constexpr Color kReference{204, 78, 70};
inline constexpr Color kHeldOut{216, 164, 158};
inline constexpr Color kFused{140, 192, 138};
inline constexpr Color kRejected{232, 121, 12};
inline constexpr Color kLandmark{28, 128, 120};
inline constexpr Color kLandmarkEllipse{132, 190, 184};
inline constexpr Color kProvisional{172, 186, 190};
inline constexpr Color kFreeCell{244, 243, 238};
inline constexpr Color kDisputedCell{226, 88, 34};
inline constexpr Color kOccupiedCell{58, 60, 66};
inline constexpr Color kParticle{232, 150, 46};
inline constexpr Color kRobot{20, 48, 98};

using Points = std::vector<Eigen::Vector2d>;

/// What could be seen of some layers, for the legend.
struct Seen {
  std::size_t online = 0;
  std::size_t uncertainty = 0;
  std::size_t path = 0;
  std::size_t reference = 0;
  std::size_t surveyed = 0;
  std::size_t fused = 0;
  std::size_t rejected = 0;
  std::size_t held_out = 0;
  std::size_t landmarks = 0;
  std::size_t landmark_ellipses = 0;
  std::size_t provisional = 0;
  std::size_t particles = 0;
  std::size_t modes = 0;
  std::size_t robot = 0;
  std::size_t robot_ellipse = 0;
};

/// A picture in the making: what is drawn, the canvas, and the view of the map on it.
struct Sheet {
  Sheet(const Content& drawn, const Style& how);

  /// Pixels of a length given for a picture of the standard size.
  double px(double at_standard_size) const { return unit * at_standard_size; }

  /// Visits the landmarks of all maps at the end that are confirmed, or those that are not.
  template <class Visit>
  void for_each_landmark(bool confirmed, Visit visit) const {
    if (!content.end) return;
    for (const MapDescription& map : content.end->maps) {
      for (const LandmarkView& landmark : map.landmarks) {
        if (landmark.confirmed == confirmed) visit(landmark);
      }
    }
  }

  const Content& content;
  const Style& style;
  double unit;
  Canvas canvas;
  View view;
  Seen seen;
};

/// An arrow head: the robot.
Points arrow(const Eigen::Vector2d& at, double yaw, double length);

// In front of and around the map.
void draw_grid(Sheet& sheet);         ///< lines at round numbers
void draw_axis_labels(Sheet& sheet);  ///< their numbers
void draw_scale_bar(Sheet& sheet);
void draw_title(Sheet& sheet);
void draw_legend(Sheet& sheet);  ///< what is drawn how, and the pose at the end

}  // namespace waymark::plot
