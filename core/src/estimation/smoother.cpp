// SPDX-License-Identifier: Apache-2.0
#include "estimation/smoother.hpp"

#include <algorithm>

#include "estimation/belief_archive.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::estimation {

void Smoother::add(const Belief& posterior, bool standing, bool resets_twist) {
  if (!nodes_.empty() && nodes_.back().stamp == posterior.stamp) {
    amend(posterior, standing);  // updates with equal stamps are one step
    nodes_.back().cut_before = nodes_.back().cut_before || cut_next_;
    nodes_.back().resets_twist = nodes_.back().resets_twist || resets_twist;
  } else {
    nodes_.push_back({posterior.stamp, posterior.mean, posterior.P, standing, cut_next_, resets_twist});
  }
  cut_next_ = false;
}

void Smoother::amend(const Belief& posterior, bool standing) {
  if (nodes_.empty()) return;
  nodes_.back().mean = posterior.mean;
  nodes_.back().P = posterior.P;
  nodes_.back().standing = standing;
}

template <class Archive>
void Smoother::serialize(Archive& archive, std::size_t size, Time now) {
  if (archive.section("smoother", 2) < 2) throw DataError("the checkpoint has an older version");
  std::uint64_t steps = size;
  archive(cut_next_, steps);
  if (steps != size) throw DataError("the checkpoint has another number of smoothed steps than announced");
  if constexpr (Archive::kReads) nodes_.clear();
  for (std::uint64_t i = 0; i < steps; ++i) {
    Node& node = i < nodes_.size() ? nodes_[i] : nodes_.emplace_back();
    Belief belief;
    if constexpr (!Archive::kReads) belief = belief_of(node);
    serialize_belief(archive, belief, process_.layout());
    if constexpr (Archive::kReads) {
      const bool is_next = (i == 0 || belief.stamp > nodes_[i - 1].stamp) && belief.stamp <= now;
      if (!is_next) throw DataError("the checkpoint has smoothed steps that are not in order");
      node.stamp = belief.stamp;
      node.mean = belief.mean;
      node.P = belief.P;
    }
    archive(node.standing, node.cut_before, node.resets_twist);
  }
}
template void Smoother::serialize(OutArchive& archive, std::size_t size, Time now);
template void Smoother::serialize(InArchive& archive, std::size_t size, Time now);

Belief Smoother::belief_of(const Node& node) const { return {node.stamp, node.mean, node.P}; }

/// The error states; without velocity and rate if the next step reset the twist.
std::vector<int> Smoother::carried_over(bool resets_twist) const {
  constexpr int kFirstOfTwist = 6;
  const StateLayout& layout = process_.layout();
  std::vector<int> carried;
  for (int i = 0; i < layout.size(); ++i) {
    bool is_twist = false;
    for (int core = kFirstOfTwist; core < kCoreStates; ++core) is_twist = is_twist || layout.active(core) == i;
    if (!(resets_twist && is_twist)) carried.push_back(i);
  }
  return carried;
}

std::vector<SmoothedPose> Smoother::smooth() const {
  const StateLayout& layout = process_.layout();
  const std::vector<int> all = carried_over(false);
  const std::vector<int> without_twist = carried_over(true);
  std::vector<SmoothedPose> result(nodes_.size());
  Belief later;
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Belief now = belief_of(nodes_[k]);
    if (k + 1 < nodes_.size() && !nodes_[k + 1].cut_before) {
      Belief predicted = now;
      process_.predict(predicted, later.stamp, nodes_[k].standing);
      const ErrorMatrix F = process_.transition(now.mean, to_seconds(later.stamp - now.stamp));
      const std::vector<int>& carried = nodes_[k + 1].resets_twist ? without_twist : all;
      const Eigen::MatrixXd before = predicted.P(carried, carried);
      const Eigen::MatrixXd PFt = now.P * F.transpose();
      const Eigen::MatrixXd G = gaussian::divide(PFt(Eigen::all, carried), before);
      const ErrorVector learnt = boxminus(later.mean, predicted.mean, layout);
      boxplus(now.mean, G * learnt(carried), layout);
      now.P += G * (later.P(carried, carried) - before) * G.transpose();
      now.P = (0.5 * (now.P + now.P.transpose())).eval();
      for (Eigen::Index i = 0; i < now.P.rows(); ++i) now.P(i, i) = std::max(now.P(i, i), 0.0);
    }
    result[k] = {now.stamp, now.mean.T_map_base, pose_covariance(now, layout)};
    later = now;
  }
  return result;
}

}  // namespace waymark::estimation
