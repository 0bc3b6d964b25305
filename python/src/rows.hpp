// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "waymark/interface/snapshot.hpp"

/// Rows of NumPy's structured arrays. Names and units are those of `waymark/__init__.pyi`.
namespace waymark::python {

struct PoseRow {
  std::int64_t stamp_ns;
  double position[3];     ///< in the map [m]
  double orientation[4];  ///< T_map_base as x, y, z, w, with w >= 0
  double yaw;             ///< [rad]
};

struct TrajectoryRow {
  std::int64_t stamp_ns;
  double position[3];
  double orientation[4];
  double yaw;
  double covariance[3][3];  ///< of (x, y, yaw)
  double velocity[3];       ///< in the base frame [m/s]
  double angular_rate[3];   ///< in the base frame [rad/s]
  double effective_sample_size;
  std::int32_t sensor;  ///< index of the measurement's sensor
  std::int32_t fate;    ///< index of `waymark.FATES`
};

struct SmoothedRow {
  std::int64_t stamp_ns;
  double position[3];
  double orientation[4];
  double yaw;
  double covariance[3][3];
};

struct ParticleRow {
  double position[3];
  double orientation[4];
  double yaw;
  double weight;
};

struct LandmarkRow {
  std::int64_t id;
  std::uint64_t birth;
  double position[2];       ///< east, north [m]
  double radius_m;          ///< NaN: unknown
  double covariance[3][3];  ///< of (east, north, radius)
  double conditional_covariance[2][2];
  double existence;
  std::int64_t sightings;
  bool confirmed;
};

struct SightingRow {
  std::int64_t stamp_ns;
  double position_base[2];
  std::int64_t landmark;
  bool is_first;
};

/// Sets the parts that all rows with a pose share.
template <class Row>
void set_pose(Row& row, const Pose& pose) {
  const double sign = pose.q.w() < 0.0 ? -1.0 : 1.0;  // q and -q are the same rotation
  for (int i = 0; i < 3; ++i) row.position[i] = pose.p(i);
  for (int i = 0; i < 4; ++i) row.orientation[i] = sign * pose.q.coeffs()(i);
  row.yaw = pose.yaw();
}

template <int N, class Matrix>
void set_matrix(double (&out)[N][N], const Matrix& matrix) {
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) out[i][j] = matrix(i, j);
  }
}

inline std::int64_t nanoseconds(Time time) { return time.time_since_epoch().count(); }

}  // namespace waymark::python
