// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estimation/ekf.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/math/random.hpp"

/// States and covariances that the tests of the filter draw.
namespace waymark::test {

inline Random stream(std::uint64_t seed) { return Random({seed, 0, 0, 0}); }

inline double uniform(Random& random, double low, double high) { return low + (high - low) * random.uniform(); }

Eigen::VectorXd normals(int size, Random& random);

/// Any pose, speeds up to 3 m/s, rates up to `rate`; in the plane if the motion is planar.
NavState random_state(const StateLayout& layout, Random& random, double rate = 1.0);

/// Positive definite, with correlations everywhere.
ErrorMatrix random_covariance(int size, Random& random, double scale = 1.0);

double smallest_eigenvalue(const ErrorMatrix& P);

double asymmetry(const ErrorMatrix& P);

inline Time at(double seconds) { return Time{from_seconds(seconds)}; }

StateBlock block_of(int states);

/// The innovation of a model of the layout's owner (-1: of none with states of its own).
void innovate(const Belief& belief, const StateLayout& layout, int owner, const Linearization& model,
              estimation::ekf::Innovation& out);

}  // namespace waymark::test
