// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "waymark/base/api.hpp"

namespace waymark {

/// Linear assignment by shortest augmenting paths with potentials (H. W. Kuhn 1955; R. Jonker, A. Volgenant 1987),
/// O(rows² · columns). Storage is reused: further calls of the same size do not allocate.
class WAYMARK_API AssignmentSolver {
 public:
  /// Assigns every row to a different column with the least sum of costs. `cost`: finite, rows <= columns; otherwise
  /// throws Error. Returns the column of every row, valid until the next call. Equal costs give equal results, also
  /// with ties.
  const std::vector<int>& solve(const Eigen::Ref<const Eigen::MatrixXd>& cost);

 private:
  void add_row(const Eigen::Ref<const Eigen::MatrixXd>& cost, std::size_t new_row);

  // Index 0 is the virtual row and column where each path starts.
  std::vector<double> row_potential_;
  std::vector<double> column_potential_;
  std::vector<double> least_;
  std::vector<std::size_t> previous_;
  std::vector<std::size_t> row_of_;
  std::vector<char> visited_;
  std::vector<int> column_of_;
};

}  // namespace waymark
