// SPDX-License-Identifier: Apache-2.0
#include "estimation/belief_archive.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::estimation {

void require_belief(const Belief& belief, const StateLayout& layout) {
  const bool fits = belief.mean.block.size() == layout.block_size() && belief.P.rows() == layout.size() &&
                    belief.P.cols() == layout.size();
  if (!fits) {
    throw DataError(
        fmt::format("the checkpoint has {} error states, the configuration {}", belief.P.rows(), layout.size()));
  }
  if (!(belief.P.diagonal().array() >= 0.0).all()) throw DataError("the checkpoint has a belief of negative variance");
}

}  // namespace waymark::estimation
