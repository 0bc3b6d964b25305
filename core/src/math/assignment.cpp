// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/assignment.hpp"

#include <limits>

#include "waymark/base/error.hpp"

namespace waymark {

const std::vector<int>& AssignmentSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& cost) {
  if (cost.rows() > cost.cols()) throw Error("assignment: more rows than columns");
  if (!cost.allFinite()) throw Error("assignment: a cost is not finite");
  const auto rows = static_cast<std::size_t>(cost.rows());
  const auto columns = static_cast<std::size_t>(cost.cols());
  row_potential_.assign(rows + 1, 0.0);
  column_potential_.assign(columns + 1, 0.0);
  row_of_.assign(columns + 1, 0);
  for (std::size_t row = 1; row <= rows; ++row) add_row(cost, row);

  column_of_.assign(rows, -1);
  for (std::size_t column = 1; column <= columns; ++column) {
    if (row_of_[column] != 0) column_of_[row_of_[column] - 1] = static_cast<int>(column - 1);
  }
  return column_of_;
}

/// Finds the shortest path from `new_row` to a free column and reassigns the rows along it.
void AssignmentSolver::add_row(const Eigen::Ref<const Eigen::MatrixXd>& cost, std::size_t new_row) {
  const std::size_t columns = row_of_.size() - 1;
  least_.assign(columns + 1, std::numeric_limits<double>::infinity());
  previous_.assign(columns + 1, 0);
  visited_.assign(columns + 1, 0);
  row_of_[0] = new_row;
  std::size_t current = 0;
  do {
    visited_[current] = 1;
    const std::size_t row = row_of_[current];
    double step = std::numeric_limits<double>::infinity();
    std::size_t next = 0;
    for (std::size_t column = 1; column <= columns; ++column) {
      if (visited_[column] != 0) continue;
      const double reduced = cost(static_cast<Eigen::Index>(row - 1), static_cast<Eigen::Index>(column - 1)) -
                             row_potential_[row] - column_potential_[column];
      if (reduced < least_[column]) {
        least_[column] = reduced;
        previous_[column] = current;
      }
      if (least_[column] < step) {
        step = least_[column];
        next = column;
      }
    }
    for (std::size_t column = 0; column <= columns; ++column) {
      if (visited_[column] != 0) {
        row_potential_[row_of_[column]] += step;
        column_potential_[column] -= step;
      } else {
        least_[column] -= step;
      }
    }
    current = next;
  } while (row_of_[current] != 0);
  while (current != 0) {
    row_of_[current] = row_of_[previous_[current]];
    current = previous_[current];
  }
}

}  // namespace waymark
