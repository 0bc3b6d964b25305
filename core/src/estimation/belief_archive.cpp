// SPDX-License-Identifier: Apache-2.0
#include "estimation/belief_archive.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::estimation {

void require_layout(const Belief& belief, const StateLayout& layout) {
  if (belief.mean.block.size() == layout.block_size() && belief.P.rows() == layout.size() &&
      belief.P.cols() == layout.size())
    return;
  throw DataError(
      fmt::format("the checkpoint has {} error states, the configuration {}", belief.P.rows(), layout.size()));
}

}  // namespace waymark::estimation
