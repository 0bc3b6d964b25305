// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "waymark/interface/snapshot.hpp"

namespace waymark::report {

/// Rounding may leave a variance slightly below zero.
inline double sigma_of(double variance) { return std::sqrt(std::max(variance, 0.0)); }

/// The estimate at one time.
struct TrackRow {
  Time stamp{};
  Pose T_map_base;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();  ///< of x, y [m²], yaw [rad²]
  double sigma_z_m = 0.0;                       ///< 0 where planar motion holds it fixed
  double sigma_roll_rad = 0.0;                  ///< the same, about the base's heading
  double sigma_pitch_rad = 0.0;
  double n_eff = 0.0;
  std::array<double, kMaxBlockStates> block{};  ///< the sensors' own states
  std::array<double, kMaxBlockStates> block_sigma{};
};

/// The estimate over time, evenly spread over the time of the log: whenever there are `kMost` rows, every second one
/// goes, and the interval grows accordingly. So memory is bounded however long a robot runs, and the choice depends on
/// the log only.
class Track {
 public:
  static constexpr std::size_t kMost = 8192;

  /// Takes the belief, if it is time for a row. Call it for started filters only.
  void add(const Snapshot& snapshot);
  /// Takes the belief in any case: the last one.
  void add_last(const Snapshot& snapshot);

  const std::vector<TrackRow>& rows() const { return rows_; }

 private:
  void put(const Snapshot& snapshot);

  std::vector<TrackRow> rows_;
  Duration interval_{};
};

}  // namespace waymark::report
