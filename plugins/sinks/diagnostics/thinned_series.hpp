// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "waymark/base/time.hpp"

namespace waymark::diagnostics {

/// Every n-th row of an endless series, at most `kCapacity` of them: whenever it is full, every second row goes and n
/// doubles. Which rows stay depends only on how many there were.
template <std::size_t Columns>
class ThinnedSeries {
 public:
  static constexpr std::size_t kCapacity = 500;
  struct Row {
    Time stamp{};
    std::array<double, Columns> values{};
  };

  /// True if the next row will be kept: for rows that are expensive to make.
  bool wants_next() const { return seen_ % stride_ == 0; }

  void add(const Row& row) {
    if (wants_next()) {
      if (rows_.size() == kCapacity) halve();
      // After halving, the row may fall between the coarser ones.
      if (wants_next()) rows_.push_back(row);
    }
    ++seen_;
  }
  void skip() { ++seen_; }

  const std::vector<Row>& rows() const { return rows_; }

 private:
  void halve() {
    for (std::size_t i = 0; 2 * i < rows_.size(); ++i) rows_[i] = rows_[2 * i];
    rows_.resize((rows_.size() + 1) / 2);
    stride_ *= 2;
  }

  std::vector<Row> rows_;
  std::uint64_t seen_ = 0;
  std::uint64_t stride_ = 1;
};

}  // namespace waymark::diagnostics
