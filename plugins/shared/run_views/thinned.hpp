// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace waymark::run_views {

/// Keeps every n-th element of an endless series; n doubles whenever there are `Limit`, so memory is bounded and the
/// choice depends on the data only.
template <class T, std::size_t Limit>
class Thinned {
 public:
  void add(const T& element) {
    last_ = element;
    if (count_++ % stride_ != 0) return;
    elements_.push_back(element);
    if (elements_.size() < Limit) return;
    for (std::size_t i = 0; 2 * i < elements_.size(); ++i) elements_[i] = std::move(elements_[2 * i]);
    elements_.resize((elements_.size() + 1) / 2);
    stride_ *= 2;
  }

  /// True if the next element will be kept: for elements that are expensive to make.
  bool wants_next() const { return count_ % stride_ == 0; }
  /// Number of all elements, those left out included.
  std::size_t count() const { return count_; }
  /// The kept elements and the last one.
  std::vector<T> elements() const {
    std::vector<T> out = elements_;
    if (count_ > 0 && (count_ - 1) % stride_ != 0) out.push_back(last_);
    return out;
  }

 private:
  std::vector<T> elements_;
  T last_{};
  std::size_t count_ = 0;
  std::size_t stride_ = 1;
};

}  // namespace waymark::run_views
