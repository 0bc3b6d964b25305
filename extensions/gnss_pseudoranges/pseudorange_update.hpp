// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>

#include "receiver.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::gnss {

/// One pseudorange with Gaussian noise.
struct RangeRow {
  Transmitter from;
  double value = 0.0;     ///< less |s| [m]
  double variance = 0.0;  ///< [m²]
};

/// Up to six pseudoranges.
class PseudorangeUpdate final : public Update {
 public:
  PseudorangeUpdate(std::shared_ptr<const Receiver> receiver, const Eigen::Vector3d& base_p_antenna)
      : receiver_(std::move(receiver)), arm_(base_p_antenna) {}

  void add(const RangeRow& row) { rows_[static_cast<std::size_t>(count_++)] = row; }

  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(count_, receiver_->states());
    const Eigen::Vector3d arm = state.nav.T_map_base.q * arm_;
    for (int i = 0; i < count_; ++i) {
      const RangeRow& row = rows_[static_cast<std::size_t>(i)];
      const ExpectedRange expected = receiver_->expect(row.from, state.nav.T_map_base.p + arm, state.block);
      out.residual[i] = row.value - expected.value;
      out.R(i, i) = row.variance;
      out.position().row(i) = expected.by_antenna;
      out.attitude().row(i) = -expected.by_antenna * so3::skew(arm);
      out.block().row(i) = expected.by_block;
    }
  }

 private:
  std::shared_ptr<const Receiver> receiver_;
  Eigen::Vector3d arm_;
  int count_ = 0;
  std::array<RangeRow, kMaxUpdateRows> rows_;
};

}  // namespace waymark::gnss
