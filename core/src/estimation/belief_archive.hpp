// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/nav_state.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::estimation {

/// One belief on a checkpoint. Reading throws DataError if it has other states than `layout`.
void save_belief(const Belief& belief, OutArchive& out);
void load_belief(Belief& belief, InArchive& in, const StateLayout& layout);

}  // namespace waymark::estimation
