// SPDX-License-Identifier: Apache-2.0
#include "estimation/belief_archive.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::estimation {

void save_belief(const Belief& belief, OutArchive& out) {
  out.value(belief.stamp);
  out.value(belief.mean.T_map_base.p);
  out.value(Eigen::Vector4d(belief.mean.T_map_base.q.coeffs()));
  out.value(belief.mean.v_base);
  out.value(belief.mean.w_base);
  out.value(belief.mean.block);
  out.value(belief.P);
}

void load_belief(Belief& belief, InArchive& in, const StateLayout& layout) {
  Eigen::Vector4d q;
  in.value(belief.stamp);
  in.value(belief.mean.T_map_base.p);
  in.value(q);
  belief.mean.T_map_base.q = Eigen::Quaterniond(q);
  in.value(belief.mean.v_base);
  in.value(belief.mean.w_base);
  in.value(belief.mean.block);
  in.value(belief.P);
  if (belief.mean.block.size() != layout.block_size() || belief.P.rows() != layout.size() ||
      belief.P.cols() != layout.size()) {
    throw DataError(
        fmt::format("the checkpoint has {} error states, the configuration {}", belief.P.rows(), layout.size()));
  }
}

}  // namespace waymark::estimation
