// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <deque>
#include <vector>

#include "estimation/belief_archive.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::particles {

/// Past beliefs of the particles, with their ancestry, so that a late measurement weights each particle at its past
/// state (docs/math/time.md).
class WAYMARK_API PastBeliefs {
 public:
  /// Stores beliefs over `span`, in at most about twenty records; zero: none.
  explicit PastBeliefs(Duration span) : span_(span), spacing_(std::max(span / 20, kLeastSpacing)) {}

  /// True if a record is due.
  bool is_due(Time now) const {
    return span_ > Duration::zero() && (records_.empty() || now - records_.back().stamp >= spacing_);
  }
  /// Adds a record at `now`, to be filled by the caller, one belief per slot. Older records that the span does not need
  /// are removed.
  std::vector<Belief>& add(Time now, std::size_t slots);
  /// Present slot i descends from slot ancestors[i] of the last record.
  void resampled(const std::vector<int>& ancestors);
  void clear() { records_.clear(); }

  /// True if `stamp` is not older than the oldest record.
  bool reach(Time stamp) const { return !records_.empty() && records_.front().stamp <= stamp; }
  /// The newest record not later than `stamp`, for the ancestor of each present slot; `reach(stamp)` must hold.
  /// `out[i]` points into this object.
  void find(Time stamp, std::size_t slots, std::vector<const Belief*>& out) const;

  /// Reading throws DataError if it does not belong to so many particles with such states at `now`.
  template <class Archive>
  void serialize(Archive& archive, std::size_t slots, const StateLayout& layout, Time now) {
    archive.section("past_beliefs", 1);
    archive.each(records_, [&](auto& each, Record& record) {
      each(record.stamp, record.ancestors);
      each.each(record.beliefs,
                [&](auto& inner, Belief& belief) { estimation::serialize_belief(inner, belief, layout); });
      if constexpr (Archive::kReads) require_slots(record, slots);
    });
    if constexpr (Archive::kReads) require_order(now);
  }

 private:
  /// Prediction covers the time between records: a few centimetres at walking pace.
  static constexpr Duration kLeastSpacing = std::chrono::milliseconds(20);
  struct Record {
    Time stamp;
    std::vector<Belief> beliefs;
    std::vector<int> ancestors;  // of the slots of the next record, or of the present ones; empty: unchanged
  };

  /// Throws DataError if the records that were read are not in order, up to `now`.
  void require_order(Time now) const;
  /// Throws DataError if a record that was read is not of so many slots, or not of one time.
  static void require_slots(const Record& record, std::size_t slots);

  Duration span_;
  Duration spacing_;
  std::deque<Record> records_;
};

}  // namespace waymark::particles
