// SPDX-License-Identifier: Apache-2.0
#include "track.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::report {
namespace {

TrackRow row_of(const Snapshot& snapshot) {
  const Belief& belief = snapshot.belief();
  const StateLayout& layout = snapshot.layout();
  TrackRow row;
  row.stamp = snapshot.stamp();
  row.T_map_base = belief.mean.T_map_base;
  row.P = pose_covariance(belief, layout);
  row.n_eff = snapshot.effective_sample_size();
  if (layout.motion() == StateLayout::Motion::spatial) {
    const int z = layout.active(2);
    const int tilt = layout.active(3);
    row.sigma_z_m = sigma_of(belief.P(z, z));
    // Errors of the attitude are rotations about the map's axes: turned to the heading they are roll and pitch.
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(-belief.mean.T_map_base.yaw()).toRotationMatrix();
    const Eigen::Matrix2d P = R * belief.P.block<2, 2>(tilt, tilt) * R.transpose();
    row.sigma_roll_rad = sigma_of(P(0, 0));
    row.sigma_pitch_rad = sigma_of(P(1, 1));
  }
  for (int i = 0; i < layout.block_size(); ++i) {
    const int place = layout.core_size() + i;
    row.block[static_cast<std::size_t>(i)] = belief.mean.block[i];
    row.block_sigma[static_cast<std::size_t>(i)] = sigma_of(belief.P(place, place));
  }
  return row;
}

}  // namespace

void Track::add(const Snapshot& snapshot) {
  if (!rows_.empty()) {
    const Duration passed = snapshot.stamp() - rows_.back().stamp;
    if (passed < Duration::zero()) return;
    // Of several measurements with one stamp the last one shows what all of them say.
    if (passed > Duration::zero() && passed < interval_) return;
  }
  put(snapshot);
}

void Track::add_last(const Snapshot& snapshot) {
  if (rows_.empty() || snapshot.stamp() >= rows_.back().stamp) put(snapshot);
}

void Track::put(const Snapshot& snapshot) {
  if (!rows_.empty() && rows_.back().stamp == snapshot.stamp()) {
    rows_.back() = row_of(snapshot);
    return;
  }
  rows_.push_back(row_of(snapshot));
  if (rows_.size() < kMost) return;
  for (std::size_t i = 0; 2 * i < rows_.size(); ++i) rows_[i] = rows_[2 * i];
  rows_.resize((rows_.size() + 1) / 2);
  interval_ = std::max<Duration>(2 * interval_, (rows_.back().stamp - rows_.front().stamp) / (kMost / 2));
}

}  // namespace waymark::report
