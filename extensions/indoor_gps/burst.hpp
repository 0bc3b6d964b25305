// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "range_update.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::indoor_gps {

/// A range, and its NIS by itself.
struct SizedRange {
  RangeRow row;
  double nis;
};

/// Distributes a burst of 1 to 24 ranges over at most four updates and returns how many ranges were left out. The gate
/// takes or rejects an update as a whole, so the ranges that fit worst get updates of their own as long as there are
/// some; any that still have to share one are left out if they do not fit by themselves. Differences to one reference
/// stay together: their noise is correlated.
inline int emplace_updates(std::vector<SizedRange>& burst, const std::shared_ptr<const Beacons>& beacons,
                           const Eigen::Vector3d& base_p_antenna, UpdateList& out) {
  constexpr double kPlausible = 0.999;  // the usual gate of the host
  const double largest_nis = gaussian::chi_squared_quantile(kPlausible, 1);
  const bool has_differences = std::ranges::any_of(burst, [](const SizedRange& one) { return one.row.reference >= 0; });
  if (has_differences) {
    std::ranges::stable_sort(burst, {}, [](const SizedRange& one) { return one.row.reference; });
  } else {
    std::ranges::stable_sort(burst, std::greater{}, &SizedRange::nis);
  }
  int left_out = 0;
  std::size_t next = 0;
  for (std::size_t slot = 0; slot < UpdateList::kSlots && next < burst.size(); ++slot) {
    const std::size_t left = burst.size() - next;
    const std::size_t later = (UpdateList::kSlots - 1 - slot) * kMaxUpdateRows;
    const std::size_t fewest = left > later ? left - later : 1;
    const std::size_t size = has_differences ? std::min<std::size_t>(left, kMaxUpdateRows) : fewest;
    RangeUpdate update(beacons, base_p_antenna);
    int rows = 0;
    for (std::size_t i = next; i < next + size; ++i) {
      if (size > 1 && burst[i].nis > largest_nis) {
        ++left_out;
        continue;
      }
      update.add(burst[i].row);
      ++rows;
    }
    if (rows > 0) out.emplace<RangeUpdate>(update);
    next += size;
  }
  return left_out;
}

}  // namespace waymark::indoor_gps
