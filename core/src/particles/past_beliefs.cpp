// SPDX-License-Identifier: Apache-2.0
#include "particles/past_beliefs.hpp"

#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::particles {

std::vector<Belief>& PastBeliefs::add(Time now, std::size_t slots) {
  Record record;
  // The newest record that is at least the span old stays; an older one gives its storage.
  while (records_.size() > 1 && records_[1].stamp <= now - span_) {
    record.beliefs.swap(records_.front().beliefs);
    records_.pop_front();
  }
  record.stamp = now;
  record.beliefs.resize(slots);
  records_.push_back(std::move(record));
  return records_.back().beliefs;
}

void PastBeliefs::resampled(const std::vector<int>& ancestors) {
  if (records_.empty()) return;
  std::vector<int>& before = records_.back().ancestors;
  if (before.empty()) {
    before = ancestors;
    return;
  }
  std::vector<int> composed(ancestors.size());
  for (std::size_t i = 0; i < ancestors.size(); ++i) composed[i] = before[static_cast<std::size_t>(ancestors[i])];
  before = std::move(composed);
}

void PastBeliefs::find(Time stamp, std::size_t slots, std::vector<const Belief*>& out) const {
  std::vector<std::size_t> slot(slots);
  for (std::size_t i = 0; i < slots; ++i) slot[i] = i;
  for (std::size_t k = records_.size(); k-- > 0;) {
    const Record& record = records_[k];
    if (!record.ancestors.empty()) {
      for (std::size_t& s : slot) s = static_cast<std::size_t>(record.ancestors[s]);
    }
    if (record.stamp > stamp) continue;
    out.resize(slots);
    for (std::size_t i = 0; i < slots; ++i) out[i] = &record.beliefs[slot[i]];
    return;
  }
}

void PastBeliefs::require_slots(const Record& record, std::size_t slots) {
  const auto is_slot = [&](int slot) { return slot >= 0 && static_cast<std::size_t>(slot) < slots; };
  const auto is_of_record = [&](const Belief& belief) { return belief.stamp == record.stamp; };
  const bool fits = record.beliefs.size() == slots && std::ranges::all_of(record.beliefs, is_of_record) &&
                    (record.ancestors.empty() || record.ancestors.size() == slots) &&
                    std::ranges::all_of(record.ancestors, is_slot);
  if (!fits) throw DataError("the checkpoint's earlier beliefs are not those of its particles");
}

void PastBeliefs::require_order(Time now) const {
  const bool ascends = std::ranges::is_sorted(records_, std::ranges::less_equal{}, &Record::stamp);
  if (!ascends || (!records_.empty() && records_.back().stamp > now))
    throw DataError("the checkpoint's earlier beliefs are not in order");
}

}  // namespace waymark::particles
