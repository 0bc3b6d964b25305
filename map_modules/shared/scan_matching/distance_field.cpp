// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/distance_field.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::scan_matching {

const std::vector<StoredDistance::Offset>& StoredDistance::disc() {
  static const std::vector<Offset> offsets = [] {
    std::vector<Offset> all;
    all.reserve(std::size_t{2 * kReach + 1} * (2 * kReach + 1));
    for (int y = -kReach; y <= kReach; ++y) {
      for (int x = -kReach; x <= kReach; ++x) {
        if (x * x + y * y > kReach * kReach) continue;
        const double steps = std::round(kSteps * std::sqrt(static_cast<double>(x * x + y * y)));
        all.push_back({static_cast<std::int8_t>(x), static_cast<std::int8_t>(y), static_cast<std::uint8_t>(steps)});
      }
    }
    std::ranges::stable_sort(all, {}, &Offset::distance);
    return all;
  }();
  return offsets;
}

const std::array<std::uint8_t, 256>& StoredDistance::first_at() {
  static const std::array<std::uint8_t, 256> first = [] {
    std::array<std::uint8_t, 256> table{};
    for (std::size_t d = 0; d < table.size(); ++d) {
      const auto it = std::ranges::lower_bound(disc(), d, {}, &Offset::distance);
      table[d] = static_cast<std::uint8_t>(it - disc().begin());
    }
    return table;
  }();
  return first;
}

}  // namespace waymark::scan_matching
