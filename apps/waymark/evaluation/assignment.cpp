// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/assignment.hpp"

#include <cstddef>
#include <limits>

namespace waymark::evaluation {

std::vector<int> assign(const Eigen::MatrixXd& cost, double limit) {
  const auto rows = static_cast<std::size_t>(cost.rows());
  const auto columns = static_cast<std::size_t>(cost.cols());
  // Every row may stay alone at a price that one more pair always undercuts; a pair over the limit costs more than all
  // of that, so it is never taken.
  const double alone = (static_cast<double>(rows) + 1.0) * (limit + 1.0);
  const double forbidden = (static_cast<double>(rows) + 1.0) * alone;
  const std::size_t all_columns = columns + rows;
  const auto price = [&](std::size_t row, std::size_t column) {
    if (column >= columns) return alone;
    const double c = cost(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
    return c <= limit ? c : forbidden;
  };

  // Shortest augmenting paths, one row at a time; index 0 is the virtual column where each path starts.
  std::vector<double> row_potential(rows + 1, 0.0);
  std::vector<double> column_potential(all_columns + 1, 0.0);
  std::vector<std::size_t> row_of(all_columns + 1, 0);
  for (std::size_t new_row = 1; new_row <= rows; ++new_row) {
    std::vector<double> least(all_columns + 1, std::numeric_limits<double>::infinity());
    std::vector<std::size_t> previous(all_columns + 1, 0);
    std::vector<bool> visited(all_columns + 1, false);
    row_of[0] = new_row;
    std::size_t current = 0;
    do {
      visited[current] = true;
      const std::size_t row = row_of[current];
      double step = std::numeric_limits<double>::infinity();
      std::size_t next = 0;
      for (std::size_t column = 1; column <= all_columns; ++column) {
        if (visited[column]) continue;
        const double reduced = price(row - 1, column - 1) - row_potential[row] - column_potential[column];
        if (reduced < least[column]) {
          least[column] = reduced;
          previous[column] = current;
        }
        if (least[column] < step) {
          step = least[column];
          next = column;
        }
      }
      for (std::size_t column = 0; column <= all_columns; ++column) {
        if (visited[column]) {
          row_potential[row_of[column]] += step;
          column_potential[column] -= step;
        } else {
          least[column] -= step;
        }
      }
      current = next;
    } while (row_of[current] != 0);
    while (current != 0) {
      row_of[current] = row_of[previous[current]];
      current = previous[current];
    }
  }

  std::vector<int> column_of(rows, -1);
  for (std::size_t column = 1; column <= columns; ++column) {
    if (row_of[column] != 0) column_of[row_of[column] - 1] = static_cast<int>(column - 1);
  }
  return column_of;
}

}  // namespace waymark::evaluation
