// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/update.hpp"

namespace waymark::estimation {

/// H of one update over the active error states, as its nonzero columns. A position fix has two, so P Hᵀ costs n × 2
/// instead of n × n.
struct StateJacobian {
  std::array<int, kMaxErrorStates> states;  ///< of each column
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUpdateRows, kMaxErrorStates> columns;
  int count = 0;             ///< columns in use
  int considered = 0;        ///< this many states, from `first_considered` on, are not estimated
  int first_considered = 0;  ///< among the error states

  /// Starts H of `rows` rows over `size` error states; no column is in use.
  void reset(int rows, int size) {
    columns.resize(rows, size);
    count = considered = first_considered = 0;
  }
  /// Adds a column, unless the state is held fixed (-1) or the column is zero.
  template <class Column>
  void add(int state, const Column& column) {
    if (state < 0 || column.isZero(0.0)) return;
    states[static_cast<std::size_t>(count)] = state;
    columns.col(count++) = column;
  }
};

/// Scatters the Jacobians of a model, from `first_part` on, and that of the sensor's own block, whose first state is
/// `block_offset` within the blocks. Adds to `out`.
WAYMARK_API void scatter(const StateLayout& layout, int block_offset, const Linearization& model, StateJacobian& out,
                         Linearization::Part first_part = Linearization::kPosition);

/// True if a model depends on how fast the base moves forwards: its sensor measures the speed. One that only says that
/// a base does not slip sideways does not.
WAYMARK_API bool observes_speed(const Linearization& model);

}  // namespace waymark::estimation
