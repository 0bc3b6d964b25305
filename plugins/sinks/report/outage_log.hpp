// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "waymark/base/time.hpp"

namespace waymark::report {

/// A time without a used fix.
struct Outage {
  Time from;
  Time to;
};

/// The outages of one sensor that fixes the position: times between two used fixes that are longer than 2 s and than
/// five times the usual one. Of more than 1000 the longest are kept. A sensor with few used fixes has none: it only
/// places the map.
class OutageLog {
 public:
  void used(Time stamp) {
    ++count_;
    if (last_ && stamp > *last_) {
      const Duration gap = stamp - *last_;
      if (gap > kShortest) {
        gaps_.push_back({*last_, stamp});
        if (gaps_.size() == 2 * kMost) keep_longest();
      } else {
        usual_sum_ += gap;
        ++usual_count_;
      }
    }
    if (!last_ || stamp > *last_) last_ = stamp;
  }

  /// In the order of time; `end` is that of the log.
  std::vector<Outage> outages(Time end) const {
    if (count_ < kFewest) return {};
    std::vector<Outage> out = gaps_;
    if (last_ && end > *last_) out.push_back({*last_, end});
    Duration usual = usual_count_ > 0 ? usual_sum_ / usual_count_ : Duration::zero();
    // A receiver slower than 0.5 Hz has no other gaps than these.
    if (usual_count_ == 0 && !gaps_.empty()) usual = median_gap();
    const Duration limit = std::max(kShortest, std::min(usual, kLongest / 5) * 5);
    std::erase_if(out, [&](const Outage& outage) { return outage.to - outage.from <= limit; });
    if (out.size() > kMost) keep_longest(out);
    return out;
  }

 private:
  static constexpr std::size_t kMost = 1000;
  static constexpr std::uint64_t kFewest = 10;
  static constexpr Duration kShortest = std::chrono::seconds(2);

  Duration median_gap() const {
    std::vector<Duration> gaps;
    for (const Outage& gap : gaps_) gaps.push_back(gap.to - gap.from);
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
    std::ranges::nth_element(gaps, middle);
    return *middle;
  }

  void keep_longest() { keep_longest(gaps_); }
  static void keep_longest(std::vector<Outage>& gaps) {
    std::ranges::stable_sort(gaps, [](const Outage& a, const Outage& b) { return a.to - a.from > b.to - b.from; });
    gaps.resize(std::min(gaps.size(), kMost));
    std::ranges::sort(gaps, {}, &Outage::from);
  }

  std::optional<Time> last_;
  std::vector<Outage> gaps_;
  Duration usual_sum_{};
  std::int64_t usual_count_ = 0;
  std::uint64_t count_ = 0;  // used fixes
};

}  // namespace waymark::report
