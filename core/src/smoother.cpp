// SPDX-License-Identifier: Apache-2.0
#include "waymark/smoother.hpp"

#include <algorithm>

#include "waymark/gaussian.hpp"

namespace waymark {

void Smoother::add(const Belief& posterior, bool standing) {
  if (!nodes_.empty() && nodes_.back().stamp == posterior.stamp) {
    amend(posterior, standing);  // updates of one moment are one step
  } else {
    nodes_.push_back({posterior.stamp, posterior.mean, posterior.P, standing, cut_next_});
  }
  cut_next_ = false;
}

void Smoother::amend(const Belief& posterior, bool standing) {
  if (nodes_.empty()) return;
  nodes_.back().mean = posterior.mean;
  nodes_.back().P = posterior.P;
  nodes_.back().standing = standing;
}

void Smoother::save(std::size_t size, OutArchive& out) const {
  out.section("smoother", 1);
  out.value(static_cast<std::uint64_t>(size));
  for (std::size_t i = 0; i < size; ++i) {
    save_belief(belief_of(nodes_[i]), out);
    out.value(nodes_[i].standing);
    out.value(nodes_[i].cut_before);
  }
}

void Smoother::load(InArchive& in) {
  in.section("smoother", 1);
  std::uint64_t size = 0;
  in.value(size);
  nodes_.clear();
  for (std::uint64_t i = 0; i < size; ++i) {
    Belief belief;
    load_belief(belief, in, process_.layout());
    Node& node = nodes_.emplace_back();
    node.stamp = belief.stamp;
    node.mean = belief.mean;
    node.P = belief.P;
    in.value(node.standing);
    in.value(node.cut_before);
  }
}

Belief Smoother::belief_of(const Node& node) const { return {node.stamp, node.mean, node.P}; }

std::vector<SmoothedPose> Smoother::smooth() const {
  const StateLayout& layout = process_.layout();
  std::vector<SmoothedPose> result(nodes_.size());
  Belief later;
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Belief now = belief_of(nodes_[k]);
    if (k + 1 < nodes_.size() && !nodes_[k + 1].cut_before) {
      Belief predicted = now;
      process_.predict(predicted, later.stamp, nodes_[k].standing);
      const ErrorMatrix F = process_.transition(now.mean, to_seconds(later.stamp - now.stamp));
      const Eigen::MatrixXd G = gaussian::divide(now.P * F.transpose(), predicted.P);
      const ErrorVector learnt = boxminus(later.mean, predicted.mean, layout);
      boxplus(now.mean, G * learnt, layout);
      now.P += G * (later.P - predicted.P) * G.transpose();
      now.P = (0.5 * (now.P + now.P.transpose())).eval();
      for (Eigen::Index i = 0; i < now.P.rows(); ++i) now.P(i, i) = std::max(now.P(i, i), 0.0);
    }
    result[k] = {now.stamp, now.mean.T_map_base, pose_covariance(now, layout)};
    later = now;
  }
  return result;
}

}  // namespace waymark
