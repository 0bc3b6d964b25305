// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <memory>

#include "beacons.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::indoor_gps {

/// One range of an update, or a difference of two.
struct RangeRow {
  int beacon = -1;        ///< index
  int reference = -1;     ///< index of the beacon whose range is subtracted, or -1
  double value = 0.0;     ///< [m]
  double sigma = 0.0;     ///< of its Gaussian part [m]
  double variance = 0.0;  ///< of the whole noise, at least sigma² [m²]
};

/// Up to six ranges at once: z = k |p + R l − b| + o, with the base at p and the antenna at l.
class RangeUpdate final : public Update {
 public:
  RangeUpdate(std::shared_ptr<const Beacons> beacons, const Eigen::Vector3d& base_p_antenna)
      : beacons_(std::move(beacons)), arm_(base_p_antenna) {}

  void add(const RangeRow& row) { rows_[static_cast<std::size_t>(count_++)] = row; }

  /// The host takes two rows of a position for east and north.
  Quantity observes() const override { return count_ == 1 ? Quantity::position : Quantity::other; }

  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(count_, beacons_->block_size());
    const Eigen::Vector3d arm = state.nav.T_map_base.q * arm_;
    const Eigen::Vector3d p_map_antenna = state.nav.T_map_base.p + arm;
    auto& by_position = out.position();
    for (int i = 0; i < count_; ++i) {
      const RangeRow& row = rows_[static_cast<std::size_t>(i)];
      const ExpectedRange expected = beacons_->expect(row.beacon, row.reference, p_map_antenna, state.block);
      out.residual[i] = row.value - expected.value;
      by_position.row(i) = expected.by_point;
      if (!arm_.isZero(0.0)) out.attitude().row(i) = -expected.by_point * so3::skew(arm);
      if (beacons_->block_size() > 0) out.block().row(i) = expected.by_block;
      out.R(i, i) = row.variance;
      for (int j = 0; j < i; ++j) out.R(i, j) = out.R(j, i) = common_variance(row, rows_[static_cast<std::size_t>(j)]);
    }
  }

 private:
  /// Differences to one reference have its noise in common: half the variance of each, if all beacons are alike.
  static double common_variance(const RangeRow& a, const RangeRow& b) {
    if (a.reference < 0 || a.reference != b.reference) return 0.0;
    return 0.5 * a.sigma * b.sigma;
  }

  std::shared_ptr<const Beacons> beacons_;
  Eigen::Vector3d arm_;
  int count_ = 0;
  std::array<RangeRow, kMaxUpdateRows> rows_;
};

}  // namespace waymark::indoor_gps
