// SPDX-License-Identifier: Apache-2.0
#include "fusion/landmark_marginals.hpp"

#include <cstddef>
#include <limits>

namespace waymark::fusion {

namespace {

using Marginals = std::span<const std::optional<joint::JointBelief::LandmarkEstimate>>;

/// Index of the landmark nearest to this one, or itself, that has a node; their number if none has.
std::size_t nearest_node(std::span<const LandmarkView> landmarks, Marginals marginal, std::size_t landmark) {
  if (marginal[landmark]) return landmark;
  std::size_t nearest = landmarks.size();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const double distance = (landmarks[i].p_map - landmarks[landmark].p_map).squaredNorm();
    if (!marginal[i] || distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

}  // namespace

void report_marginals(std::span<LandmarkView> landmarks, Marginals marginal, std::span<const Eigen::Matrix2d> own) {
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    auto P = landmarks[i].P.topLeftCorner<2, 2>();
    landmarks[i].P_conditional = P;
    const std::size_t node = nearest_node(landmarks, marginal, i);
    if (node == landmarks.size()) continue;
    const Eigen::Vector2d off = landmarks[node].p_map - marginal[node]->p;
    P = marginal[node]->P + off * off.transpose();
    if (node != i) P += own[i];
  }
}

}  // namespace waymark::fusion
