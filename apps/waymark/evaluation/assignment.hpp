// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace waymark::evaluation {

/// Pairs rows with columns one to one: as many pairs as can be with cost <= `limit`, and among those the least sum of
/// costs. Costs are >= 0. Hungarian method with potentials, O(rows² · (rows + columns)). Returns each row's column, or
/// -1.
std::vector<int> assign(const Eigen::MatrixXd& cost, double limit);

}  // namespace waymark::evaluation
