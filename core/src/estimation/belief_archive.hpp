// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/nav_state.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::estimation {

/// Writes and reads one belief of a checkpoint. Reading throws DataError if its size does not match `layout`.
void save_belief(const Belief& belief, OutArchive& out);
void load_belief(Belief& belief, InArchive& in, const StateLayout& layout);

}  // namespace waymark::estimation
