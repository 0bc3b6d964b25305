// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/paper/spread.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/waymark/evaluation/trajectory_error.hpp"

namespace waymark::paper {

std::string spread(const std::vector<double>& values, int digits) {
  if (values.empty()) return "-";
  const auto [least, most] = std::ranges::minmax(values);
  return fmt::format("{:.{}f} / **{:.{}f}** / {:.{}f}", least, digits, evaluation::statistics(values).median, digits,
                     most, digits);
}

}  // namespace waymark::paper
