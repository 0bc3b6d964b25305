// SPDX-License-Identifier: Apache-2.0
#include "estimation/belief_archive.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::estimation {

namespace {

template <class Archive, class AnyBelief>
void fields(Archive& archive, AnyBelief& belief) {
  auto& mean = belief.mean;
  archive(belief.stamp, mean.T_map_base.p, mean.T_map_base.q, mean.v_base, mean.w_base, mean.block, belief.P);
}

}  // namespace

void save_belief(const Belief& belief, OutArchive& out) { fields(out, belief); }

void load_belief(Belief& belief, InArchive& in, const StateLayout& layout) {
  fields(in, belief);
  if (belief.mean.block.size() != layout.block_size() || belief.P.rows() != layout.size() ||
      belief.P.cols() != layout.size()) {
    throw DataError(
        fmt::format("the checkpoint has {} error states, the configuration {}", belief.P.rows(), layout.size()));
  }
}

}  // namespace waymark::estimation
