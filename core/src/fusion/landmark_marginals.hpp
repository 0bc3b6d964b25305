// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "joint/joint_belief.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/map_view.hpp"

namespace waymark::fusion {

/// Gives landmarks their marginal covariance, and the one that they have as `P_conditional`: that of their node of the
/// joint Gaussian, about the place of the report. One without a node is as uncertain as the nearest one that has a
/// node, and by its covariance given the path, `own`, besides. `marginal` and `own`: of each landmark, in the frame of
/// the report.
WAYMARK_API void report_marginals(std::span<LandmarkView> landmarks,
                                  std::span<const std::optional<joint::JointBelief::LandmarkEstimate>> marginal,
                                  std::span<const Eigen::Matrix2d> own);

}  // namespace waymark::fusion
