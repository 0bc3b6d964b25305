// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <vector>

#include "fusion/committed.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::fusion {

/// The last measurements of a host without maps, in order, with marks to roll back to. A late measurement is inserted
/// in order, and all after it are processed again. The result is byte-identical to that of a log in order.
class History {
 public:
  /// `span` zero: nothing is stored, and late measurements are ignored.
  explicit History(Duration span) : span_(span) {}

  bool keeps() const { return span_ > Duration::zero(); }
  /// True if a mark is due before the next measurement.
  bool needs_mark() const { return marks_.empty() || count_ - marks_.back().at >= kSpacing; }
  /// Adds a mark before the next measurement and removes all that is older than the span.
  void mark(Mark&& mark);
  /// Adds the next measurement in order.
  void append(const Measurement& m);
  /// Number of measurements since the start of the filter.
  std::uint64_t count() const { return count_; }

  /// True if a measurement with this stamp can be inserted.
  bool reaches(Time stamp) const { return !marks_.empty() && marks_.front().stamp <= stamp; }
  /// Rolls back to the newest mark before `late` and returns it. The measurements after it, with `late` inserted, are
  /// moved to `again` and must be appended again.
  const Mark& rewind(const Measurement& late, std::vector<Measurement>& again);

  /// Forgets all: nothing before now is processed again.
  void clear();
  /// Begins with the mark of a checkpoint.
  void begin(Mark&& mark);
  const std::deque<Mark>& marks() const { return marks_; }
  /// For a checkpoint, which lists fields for writing and reading alike; there must be one.
  Mark& oldest_mark() { return marks_.front(); }
  /// The measurements from the oldest mark on, in order.
  const std::deque<Measurement>& log() const { return log_; }

 private:
  /// Measurements between marks. A mark costs about as much as two updates. A late measurement repeats half of them on
  /// average.
  static constexpr std::uint64_t kSpacing = 16;

  Duration span_;
  std::deque<Measurement> log_;  // from the oldest mark on
  std::deque<Mark> marks_;
  std::uint64_t count_ = 0;
};

}  // namespace waymark::fusion
