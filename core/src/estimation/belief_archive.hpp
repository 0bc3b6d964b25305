// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/nav_state.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::estimation {

/// Throws DataError if a belief that was read has other states than `layout`, or a negative variance.
void require_belief(const Belief& belief, const StateLayout& layout);

/// One belief on a checkpoint. Reading throws DataError if it has other states than `layout`, or a negative variance.
template <class Archive>
void serialize_belief(Archive& archive, Belief& belief, const StateLayout& layout) {
  NavState& mean = belief.mean;
  archive(belief.stamp, mean.T_map_base.p, mean.T_map_base.q, mean.v_base, mean.w_base, mean.block, belief.P);
  if constexpr (Archive::kReads) require_belief(belief, layout);
}

}  // namespace waymark::estimation
