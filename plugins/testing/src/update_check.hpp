// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "findings.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/random.hpp"
#include "waymark/testing/sensor_contract.hpp"

namespace waymark::testing {

/// An update's model at one state, with zeros where it uses nothing.
struct DenseModel {
  Eigen::VectorXd residual;
  Eigen::MatrixXd R;
  Eigen::MatrixXd H;    ///< rows × active states of the layout
  std::string problem;  ///< not empty: the shapes do not fit, and nothing else is filled in

  /// All numbers, exactly.
  std::string bytes() const;
};

/// Calls `linearize` with `out` and spreads the blocks over the active states. The layout has one owner, the sensor.
DenseModel evaluate(const Update& update, const NavState& state, const StateLayout& layout, Linearization& out);

/// A random state around the setting's center, planar or spatial as the layout says.
NavState random_state(Random& random, const SensorSetting& setting, const StateLayout& layout);

/// Checks one update at all `states`: values, noise, Jacobians, purity, and that threads do not disturb each other.
void check_update(const Update& update, const std::vector<NavState>& states, const StateLayout& layout,
                  std::string_view name, Findings& findings);

}  // namespace waymark::testing
