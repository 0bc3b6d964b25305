// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "waymark/base/api.hpp"

namespace waymark {

/// Linear assignment by shortest augmenting paths with potentials (H. W. Kuhn 1955; R. Jonker, A. Volgenant 1987),
/// O(rows² · columns). Keeps its storage, so that a warm solver does not allocate.
class WAYMARK_API AssignmentSolver {
 public:
  /// Gives every row a column of its own so that the sum of the costs is least. `cost`: finite, rows <= columns (or it
  /// throws Error). Returns each row's column, valid until the next call. The same costs give the same answer, ties
  /// too.
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
