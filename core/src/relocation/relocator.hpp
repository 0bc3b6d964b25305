// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "loops/window_matcher.hpp"
#include "relocation/placement.hpp"
#include "waymark/base/api.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_view.hpp"

namespace waymark::relocation {

/// A mapping step, as a search for the robot sees it.
struct Look {
  Eigen::Vector3d moved;  ///< (x, y, yaw) of the base since the last step, by dead reckoning, in its axes then
  Eigen::Vector3d xyyaw;  ///< of the base in the map, as the filter has it
  std::span<const Eigen::Vector2f> points_base;  ///< of surfaces, in the base frame [m]
  bool is_written = false;                       ///< the map is gone on with, so that its unknown cells are no misfit
};

/// Where the robot was found.
struct Place {
  Eigen::Vector3d xyyaw;  ///< of the base in the map
  Eigen::Matrix3d P;      ///< its covariance
};

/// Notices that a robot is not where it is believed to be in a loaded map, and finds it anywhere in it: what the
/// robot sees fits the map worse than it usually does (fast and slow averages of the likelihood, after S. Thrun,
/// W. Burgard, D. Fox, *Probabilistic Robotics*, 2005, §8.3.5); then the scans since are searched in the whole map
/// until one place alone fits (docs/math/relocation.md). Deterministic; copies are independent.
class WAYMARK_API Relocator {
 public:
  /// A map with a larger half side is not searched [m].
  static constexpr double kLargestReach = 100.0;

  /// `map`: the loaded one. Throws Error if it is larger than `kLargestReach`, has cells of more than 0.2 m, or nothing
  /// occupied.
  explicit Relocator(GridView map);

  /// Adds a mapping step. The place, where the robot is lost and was found elsewhere.
  std::optional<Place> add(const Look& look);
  /// True while what the robot sees does not fit the map where it is believed to be.
  bool is_lost() const { return is_lost_; }
  Placement placement() const;
  /// The pose was set anew: how well it fits is not known, and what was seen before does not count.
  void begin_anew();

  /// How well what the robot saw of late fits the map, 0 … 1.
  double fit() const { return fast_; }

  /// Reading throws DataError if what is read does not fit together.
  template <class Archive>
  void serialize(Archive& archive);

 private:
  /// A scan of the window; its pose is in the axes of the window's first one.
  struct Seen {
    Eigen::Vector3d xyyaw;
    double way = 0.0;
    std::vector<Eigen::Vector2f> points;
  };

  /// What is occupied, in the map [m].
  struct Surfaces {
    std::vector<Eigen::Vector2d> points;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    double reach = 0.0;  // half of the longer side
  };
  static Surfaces surfaces_of(const GridView& map);
  Relocator(const Surfaces& surfaces, GridView&& map);

  bool is_doubtful() const;
  std::optional<double> fit_of(const Look& look);
  std::uint8_t cell_at(const Eigen::Vector2d& p_grid) const;
  bool says_something(const Eigen::Vector2d& from_grid, const Eigen::Vector2d& to_grid) const;
  void judge(double fit);
  void keep(const Look& look);
  void forget_window();
  std::optional<Place> search(const Eigen::Vector3d& believed);
  Eigen::Vector3d in_raster(const Eigen::Vector3d& xyyaw) const;

  GridView map_;
  Pose T_grid_map_;
  Eigen::Vector2d middle_;  // of the map's surfaces: the middle of the raster
  double reach_;            // half side of the search
  double search_every_;     // [m]
  loops::WindowMatcher matcher_;
  double fast_ = 0.0;
  double slow_ = 0.0;
  int steps_ = 0;  // that fitted, up to as many as are counted
  bool is_lost_ = false;
  bool is_ambiguous_ = false;
  std::vector<Seen> window_;
  int searches_ = 0;                      // of the window, modulo their lengths
  double searched_way_ = 0.0;             // of the window, at the last search
  std::vector<Eigen::Vector2f> counted_;  // points of the last step that count
};

}  // namespace waymark::relocation
