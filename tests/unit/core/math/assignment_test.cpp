// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

double sum_of(const Eigen::MatrixXd& cost, const std::vector<int>& columns) {
  double sum = 0.0;
  for (std::size_t row = 0; row < columns.size(); ++row) sum += cost(static_cast<Eigen::Index>(row), columns[row]);
  return sum;
}

/// The least sum over all ways to choose different columns.
double least_sum(const Eigen::MatrixXd& cost) {
  std::vector<int> columns(static_cast<std::size_t>(cost.cols()));
  std::iota(columns.begin(), columns.end(), 0);
  double least = 1e300;
  do {
    least = std::min(least, sum_of(cost, {columns.begin(), columns.begin() + cost.rows()}));
  } while (std::next_permutation(columns.begin(), columns.end()));
  return least;
}

TEST(AssignmentSolver, FindsTheLeastSumOfAllWays) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> price(-10.0, 10.0);
  AssignmentSolver solver;
  for (int k = 0; k < 200; ++k) {
    const int rows = 1 + k % 5;
    const int columns = rows + k % 3;
    const Eigen::MatrixXd cost = Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return price(random); });
    std::vector<int> found = solver.solve(cost);
    EXPECT_NEAR(sum_of(cost, found), least_sum(cost), 1e-9);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "no two rows share a column";
  }
}

TEST(AssignmentSolver, TheCheapestPairIsNotAlwaysInTheCheapestAssignment) {
  Eigen::Matrix2d cost;
  cost << 1.0, 2.0, 1.5, 9.0;
  EXPECT_EQ(AssignmentSolver().solve(cost), (std::vector<int>{1, 0}));
}

TEST(AssignmentSolver, NoRowsNeedNoColumns) { EXPECT_TRUE(AssignmentSolver().solve(Eigen::MatrixXd(0, 3)).empty()); }

TEST(AssignmentSolver, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(AssignmentSolver().solve(Eigen::MatrixXd::Zero(3, 2)), Error);
  EXPECT_THROW(AssignmentSolver().solve(Eigen::MatrixXd::Constant(1, 1, std::nan(""))), Error);
}

}  // namespace
}  // namespace waymark
