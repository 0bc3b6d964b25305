// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waymark::paper {

/// "min / **median** / max" of what the seeds gave, as every table of `waymark paper` writes it; "-" of none.
std::string spread(const std::vector<double>& values, int digits);

}  // namespace waymark::paper
