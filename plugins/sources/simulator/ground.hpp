// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace waymark::simulator {

/// Height of a surface at one place, with its first and second derivatives along x and y of the map.
struct Slope {
  double z = 0.0;  ///< [m]
  double z_x = 0.0, z_y = 0.0;
  double z_xx = 0.0, z_xy = 0.0, z_yy = 0.0;  ///< [1/m]
};

/// A floor or a ramp above the ground. It rises along its length from one height to the other; the slope grows and
/// falls linearly over the rounding at both ends, so that the surface has no kink. Solid from its base up.
struct Deck {
  Eigen::Vector2d from;   ///< middle of the one end, in the map [m]
  Eigen::Vector2d along;  ///< unit vector to the other end
  double length_m;        ///< seen from above
  double half_width_m;
  double from_m;      ///< height of the one end
  double to_m;        ///< height of the other
  double rounding_m;  ///< at each end; more than 0, at most half the length
  double base_m;      ///< height of its underside

  double steepest() const { return (to_m - from_m) / (length_m - rounding_m); }  ///< slope in the middle
  bool covers(const Eigen::Vector2d& p) const;
  /// At the distance `s` from the first end; level beyond the ends.
  double height(double s) const;
};

/// One of the waves that add up to uneven ground: z = amplitude sin(k·p + phase).
struct Wave {
  Eigen::Vector2d k;  ///< [rad/m]
  double phase_rad;
  double amplitude_m;
};

/// What the robot drives on: the ground, z = 0, with ramps and floors above it. The waves lie on all of them.
class Ground {
 public:
  static constexpr int kLowest = -1;  ///< the number of the ground itself; decks count from 0

  Ground() = default;  ///< level everywhere
  Ground(std::vector<Deck> decks, std::vector<Wave> waves);

  bool is_level() const { return decks_.empty() && waves_.empty(); }
  const std::vector<Deck>& decks() const { return decks_; }
  const std::vector<Wave>& waves() const { return waves_; }
  double highest_wave_m() const { return highest_wave_m_; }  ///< no bump is higher, no hollow deeper

  /// The surface of a deck, or of the ground, at a place; a deck goes on level beyond its ends.
  Slope at(int deck, const Eigen::Vector2d& p) const;

  /// On what a wheel stands that comes to a place at the height `z`: the highest surface that is not above it. Nothing
  /// if it runs into a deck from the side.
  std::optional<int> below(const Eigen::Vector2d& p, double z) const;

  /// Distance [m] along the unit vector `direction` to the first surface that is nearer than `nearest`, else `nearest`.
  /// `with_lowest`: the ground itself is there to be seen.
  double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, bool with_lowest, double nearest) const;

 private:
  double waves_at(const Eigen::Vector2d& p) const;
  double cast_deck(const Deck& deck, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                   double nearest) const;
  double cast_lowest(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double nearest) const;

  std::vector<Deck> decks_;
  std::vector<Wave> waves_;
  double highest_wave_m_ = 0.0;
  double steepest_wave_ = 0.0;
};

}  // namespace waymark::simulator
