// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "late_signal.hpp"
#include "pseudoranges.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::gnss {

using BlockRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxBlockStates>;

/// Where a signal came from.
struct Transmitter {
  Eigen::Vector3d p_map;  ///< the satellite in the map [m]
  int system = 0;         ///< place of its system in the list
  double since_s = 0.0;   ///< Δt, from the first epoch on, for the clock's drift [s]
};

/// What a pseudorange should be, and how it depends on the antenna's place and on the receiver's states.
struct ExpectedRange {
  double value = 0.0;             ///< less the satellite's distance from the map's origin [m]
  Eigen::RowVector3d by_antenna;  ///< ∂/∂(place in the map) [-]
  BlockRow by_block;              ///< ∂/∂(states)
};

/// The receiver: its clock, its noise, and the height of its antenna. States: the clock's offset, whose random walk is
/// the noise of its frequency; its drift, which is constant; an offset for each system but the first; and the height
/// above the map's plane if that is one.
class Receiver {
 public:
  /// Reads the keys of the sensor. Throws ConfigError.
  explicit Receiver(const Config& config);

  const StateBlock& block() const { return block_; }
  int states() const { return static_cast<int>(block_.size()); }
  /// Place of a system in the list, or −1.
  int find_system(int number) const;

  /// z − |s| = |p + h − s| − |s| + c + d Δt + c_system, for the antenna at p, `at` s and Δt. `states` may be null: all
  /// zero.
  ExpectedRange expect(const Transmitter& at, const Eigen::Vector3d& p_map_antenna, const double* states) const;

  /// Noise of a signal: σ, and the share of reflections by its carrier to noise density.
  LateSignal noise(const Pseudoranges::One& one) const;
  double least_elevation() const { return least_elevation_; }  ///< [rad]
  double error_time() const { return error_time_; }            ///< how long errors stay [s]

 private:
  std::vector<std::int64_t> systems_;
  double sigma_;
  bool use_reported_sigma_;
  double late_excess_;
  double open_cn0_;
  double blocked_cn0_;
  double least_elevation_;
  double error_time_;
  bool has_height_ = false;
  StateBlock block_;
};

}  // namespace waymark::gnss
