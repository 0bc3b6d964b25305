// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <deque>
#include <vector>

#include "estimation/belief_archive.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::particles {

/// What the particles believed a short while ago, and who descends from whom: so that a measurement that comes late can
/// be weighed where each particle was then (docs/math/time.md).
class WAYMARK_API PastBeliefs {
 public:
  /// Reaches back `span`, in at most about twenty records; zero: nothing is kept.
  explicit PastBeliefs(Duration span) : span_(span), spacing_(std::max(span / 20, kLeastSpacing)) {}

  /// True if it is time for another record.
  bool wants(Time now) const {
    return span_ > Duration::zero() && (records_.empty() || now - records_.back().stamp >= spacing_);
  }
  /// A new record at `now`, to be filled by the caller, one belief per slot; what is older than the span is forgotten.
  std::vector<Belief>& add(Time now, std::size_t slots);
  /// Slot i of now descends from slot ancestors[i] of what was recorded last.
  void resampled(const std::vector<int>& ancestors);
  void clear() { records_.clear(); }

  /// True if `stamp` is not older than the oldest record.
  bool reach(Time stamp) const { return !records_.empty() && records_.front().stamp <= stamp; }
  /// The newest record not later than `stamp`, for the ancestor of each slot of now; `reach(stamp)` must hold.
  /// `out[i]` points into this object.
  void find(Time stamp, std::size_t slots, std::vector<const Belief*>& out) const;

  /// Reading throws DataError if it does not belong to so many particles with such states.
  template <class Archive>
  void serialize(Archive& archive, std::size_t slots, const StateLayout& layout) {
    archive.section("past_beliefs", 1);
    archive.each(records_, [&](auto& each, Record& record) {
      each(record.stamp, record.ancestors);
      each.each(record.beliefs,
                [&](auto& inner, Belief& belief) { estimation::serialize_belief(inner, belief, layout); });
      if constexpr (Archive::kReads) require_slots(record, slots);
    });
  }

 private:
  /// Prediction bridges what lies between records: a few centimetres at walking pace.
  static constexpr Duration kLeastSpacing = std::chrono::milliseconds(20);
  struct Record {
    Time stamp;
    std::vector<Belief> beliefs;
    std::vector<int> ancestors;  // of the next record's slots, or of now's; empty: each its own
  };

  /// Throws DataError if a record that was read is not of so many slots.
  static void require_slots(const Record& record, std::size_t slots);

  Duration span_;
  Duration spacing_;
  std::deque<Record> records_;
};

}  // namespace waymark::particles
