// SPDX-License-Identifier: Apache-2.0
#include "fusion/history.hpp"

#include <algorithm>
#include <iterator>

#include "fusion/measurement_queue.hpp"

namespace waymark::fusion {

void History::mark(Mark&& mark) {
  marks_.push_back(std::move(mark));
  // The newest mark that is at least the span old stays, with all after it.
  while (marks_.size() > 1 && marks_[1].stamp <= marks_.back().stamp - span_) {
    log_.erase(log_.begin(), log_.begin() + static_cast<std::ptrdiff_t>(marks_[1].at - marks_[0].at));
    marks_.pop_front();
  }
}

void History::append(const Measurement& m) {
  log_.push_back(m);
  ++count_;
}

const Mark& History::rewind(const Measurement& late, std::vector<Measurement>& again) {
  const auto place = log_.insert(std::upper_bound(log_.begin(), log_.end(), late, MeasurementQueue::Order{}), late);
  const std::uint64_t position = marks_.front().at + static_cast<std::uint64_t>(place - log_.begin());
  while (marks_.size() > 1 && marks_.back().at > position) marks_.pop_back();
  const auto from = log_.begin() + static_cast<std::ptrdiff_t>(marks_.back().at - marks_.front().at);
  again.assign(std::make_move_iterator(from), std::make_move_iterator(log_.end()));
  log_.erase(from, log_.end());
  count_ = marks_.back().at;
  return marks_.back();
}

void History::clear() {
  log_.clear();
  marks_.clear();
}

void History::begin(Mark&& mark) {
  clear();
  count_ = mark.at;
  marks_.push_back(std::move(mark));
}

}  // namespace waymark::fusion
