// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "apps/waymark/sweep/summary.hpp"

namespace waymark::sweep {

/// A picture (SVG) of score number `index`: a line for every row of the table with a dot for each seed, a bar at the
/// median (or the mean, where the score is judged by it), and the marks as dashed lines. Empty if there are no values.
std::string strip_plot(const Score& score, const Summary& summary, std::size_t index);

}  // namespace waymark::sweep
