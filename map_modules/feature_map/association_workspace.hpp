// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "waymark/math/assignment.hpp"

namespace waymark {

/// Storage of the association methods: kept from step to step, so that a warm step does not allocate.
struct AssociationWorkspace {
  // Optimal assignment.
  AssignmentSolver solver;
  std::vector<double> cost;
  std::vector<int> component;     ///< per detection: the smallest index of those it competes with
  std::vector<int> first_seeker;  ///< per nearby landmark: a detection that may be it, or -1
  std::vector<int> rows;          ///< detections of one component
  std::vector<int> columns;       ///< landmarks of one component
  std::vector<int> column_of;     ///< per nearby landmark: its column, or -1

  // Joint compatibility.
  struct JointCandidate {
    int nearby;
    double log_signature;
    Eigen::Vector3d nu;  ///< the first 2 or 3 rows count, and so below
    Eigen::Matrix3d H;   ///< by the pose
    Eigen::Matrix3d C;   ///< Σ_θ + R
  };
  std::vector<JointCandidate> candidates;
  std::vector<std::size_t> begin_of;  ///< per detection: its candidates begin here
  std::vector<int> chosen;            ///< per detection: index of its candidate, or -1
  std::vector<int> best;
};

}  // namespace waymark
