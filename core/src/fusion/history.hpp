// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <vector>

#include "fusion/committed.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::fusion {

/// The last measurements of a host without maps, in their order, with marks to go back to: a measurement that comes
/// late is put where it belongs, and all after it are processed once more. The result is that of a log in order, to the
/// byte.
class History {
 public:
  /// Zero: nothing is kept, and what comes late is lost.
  explicit History(Duration span) : span_(span) {}

  bool keeps() const { return span_ > Duration::zero(); }
  /// True if a mark should be set before the next measurement.
  bool wants_mark() const { return marks_.empty() || count_ - marks_.back().at >= kSpacing; }
  /// Sets a mark before the next measurement; what lies farther back than the span is forgotten.
  void mark(Mark&& mark);
  /// The next measurement in order.
  void append(const Measurement& m);
  std::uint64_t count() const { return count_; }

  /// True if a measurement of this stamp can be put in order.
  bool reaches(Time stamp) const { return !marks_.empty() && marks_.front().stamp <= stamp; }
  /// Goes back to the newest mark before `late`, which stays; what came after it, with `late` in its place, is moved to
  /// `again`, to be appended once more.
  const Mark& rewind(const Measurement& late, std::vector<Measurement>& again);

  /// Begins with a mark out of a checkpoint.
  void begin(Mark&& mark);
  const std::deque<Mark>& marks() const { return marks_; }
  /// For a checkpoint, which lists fields for writing and reading alike; there must be one.
  Mark& oldest_mark() { return marks_.front(); }
  /// The measurements from the oldest mark on, in order.
  const std::deque<Measurement>& log() const { return log_; }

 private:
  /// Measurements between marks: a mark costs about as much as two updates, and half of them are repeated for nothing
  /// when something comes late.
  static constexpr std::uint64_t kSpacing = 16;

  Duration span_;
  std::deque<Measurement> log_;  // from that of the oldest mark
  std::deque<Mark> marks_;
  std::uint64_t count_ = 0;
};

}  // namespace waymark::fusion
