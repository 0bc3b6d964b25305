// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/assignment.hpp"

#include "waymark/math/assignment.hpp"

namespace waymark::evaluation {

std::vector<int> assign(const Eigen::MatrixXd& cost, double limit) {
  const Eigen::Index rows = cost.rows();
  const Eigen::Index columns = cost.cols();
  // Every row may stay alone at a price that one more pair always undercuts; a pair over the limit costs more than all
  // of that, so it is never taken.
  const double alone = (static_cast<double>(rows) + 1.0) * (limit + 1.0);
  const double forbidden = (static_cast<double>(rows) + 1.0) * alone;
  Eigen::MatrixXd price = Eigen::MatrixXd::Constant(rows, columns + rows, alone);
  price.leftCols(columns) = (cost.array() <= limit).select(cost.array(), forbidden).matrix();

  std::vector<int> column_of = AssignmentSolver().solve(price);
  for (int& column : column_of) {
    if (column >= columns) column = -1;
  }
  return column_of;
}

}  // namespace waymark::evaluation
