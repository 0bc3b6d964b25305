// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "waymark/config/config.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::indoor_gps {

/// A radio beacon whose place is known.
struct Beacon {
  int number;             ///< as in the payload
  Eigen::Vector3d p_map;  ///< [m]
  bool has_height;        ///< false: given by [x, y] only; its distance is the one in the plane
};

/// One state, or one per beacon, that all ranges have in common: their scale, or their offset.
struct SharedState {
  double initial = 0.0;
  double sigma = 0.0;            ///< of the first value; 0, and no walk: no state
  double walk_per_sqrt_s = 0.0;  ///< random walk
  bool per_beacon = false;

  bool is_estimated() const { return sigma > 0.0 || walk_per_sqrt_s > 0.0; }
};

/// What a range, or a difference of ranges, should be: the model, and its derivatives.
struct ExpectedRange {
  using BlockRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxBlockStates>;

  double value = 0.0;                                        ///< [m]
  Eigen::RowVector3d by_point = Eigen::RowVector3d::Zero();  ///< by the antenna's position in the map [-]
  BlockRow by_block;                                         ///< by the sensor's own states
};

/// Places of the beacons and the model of a range, z = k |p − b| + o with the antenna at p, the beacon at b, a scale k
/// and an offset o, each constant, or a state for all beacons, or one of each beacon. Immutable.
class Beacons {
 public:
  /// Reads `beacons` and the keys of scale and offset. Throws ConfigError.
  explicit Beacons(const Config& config);

  const std::vector<Beacon>& all() const { return beacons_; }
  /// Index of the beacon with this number, or -1.
  int find(int number) const;

  /// The sensor's own states: scale or scales [-], then offset or offsets [m].
  StateBlock block() const;
  int block_size() const { return block_size_; }

  /// The range of beacon `beacon` (an index), less that of `reference` unless that is -1. `block`: the sensor's own
  /// states; null: their initial values.
  ExpectedRange expect(int beacon, int reference, const Eigen::Vector3d& p_map_antenna, const double* block) const;

 private:
  void add_leg(int beacon, double sign, const Eigen::Vector3d& p_map_antenna, const double* block,
               ExpectedRange& out) const;
  int states_of(const SharedState& state) const;
  int scale_index(int beacon) const;
  int offset_index(int beacon) const;

  std::vector<Beacon> beacons_;
  SharedState scale_;
  SharedState offset_;
  int block_size_ = 0;
};

}  // namespace waymark::indoor_gps
