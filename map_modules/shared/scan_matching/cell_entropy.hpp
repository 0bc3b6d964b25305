// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace waymark::scan_matching {

/// Entropy of a cell that is occupied with probability p, 0 < p < 1 [bit]: 0 is crisp, 1 is no information.
inline double entropy_bit(double p) { return -(p * std::log2(p) + (1.0 - p) * std::log2(1.0 - p)); }

}  // namespace waymark::scan_matching
