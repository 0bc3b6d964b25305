// SPDX-License-Identifier: Apache-2.0
#include "joint/joint_gaussian.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

#include "waymark/math/so3.hpp"

namespace waymark::joint {

namespace {

using Square = DistantNodes::Square;

/// W ← W L⁻ᵀ.
template <class W>
void divide(W&& w, const Eigen::LLT<Square>& factor) {
  factor.matrixU().template solveInPlace<Eigen::OnTheRight>(w);
}

}  // namespace

void JointGaussian::start(const Belief& prior) {
  belief_ = prior;
  nodes_.clear();
  distant_.clear();
  size_ = 0;
  pending_columns_ = 0;
  cross_.resize(0, layout_.size());
  between_.resize(0, 0);
  pending_.resize(0, kPending);
  reserve(kFirstStates);
}

void JointGaussian::restart(const Belief& belief) {
  belief_ = belief;
  cross_.topRows(size_).setZero();
  distant_.forget_navigation();
}

void JointGaussian::restart(const Belief& belief, std::span<const NodeId> kept,
                            const Eigen::Matrix<double, Eigen::Dynamic, 3>& cross, const Eigen::MatrixXd& between) {
  belief_ = belief;
  distant_.clear();
  pending_columns_ = 0;
  std::erase_if(nodes_, [&](const Node& node) { return !std::ranges::binary_search(kept, node.id); });
  size_ = 0;
  for (Node& node : nodes_) {
    node.offset = size_;
    node.is_near = true;
    size_ += node.size;
  }
  assert(size_ == between.rows() && size_ == cross.rows());
  reserve(size_);
  cross_.topRows(size_).setZero();
  for (int i = 0; i < 3; ++i)
    cross_.topRows(size_).col(layout_.pose_indices()[static_cast<std::size_t>(i)]) = cross.col(i);
  between_.topLeftCorner(size_, size_) = between;
  corrections_.head(size_).setZero();
  if (size_ > limits_.most) choose_near(nullptr);
}

/// The mean changes, but not what its errors mean: one that is a motion of the whole map stays one, δp' = δp + δφ × (p'
/// − p). So no correction gives information about where the map lies or how it is turned.
void JointGaussian::correct(const Factor& own, const gaussian::Vector& white, int first_considered, int considered) {
  ErrorVector delta = own * white;
  delta.segment(first_considered, considered).setZero();
  const Eigen::Vector3d before = belief_.mean.T_map_base.p;
  boxplus(belief_.mean, delta, layout_);
  if (size_ > 0) corrections_.head(size_).noalias() += W_.topLeftCorner(size_, own.cols()) * white;
  const Eigen::Matrix3d by_attitude = -so3::skew(belief_.mean.T_map_base.p - before);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int row = layout_.active(i);
      const int attitude = layout_.active(3 + j);
      const double factor = by_attitude(i, j);
      if (row < 0 || attitude < 0 || factor == 0.0) continue;
      belief_.P.row(row) += factor * belief_.P.row(attitude);
      belief_.P.col(row) += factor * belief_.P.col(attitude);
      cross_.topRows(size_).col(row) += factor * cross_.topRows(size_).col(attitude);
      distant_.add(row, factor, attitude);
    }
  }
}

void JointGaussian::predict(const estimation::ProcessModel& process, Time to, bool standing) {
  if (!nodes_.empty()) {
    // F is the identity plus rows of the pose, and the decay of the blocks.
    const ErrorMatrix F = process.transition(belief_.mean, to_seconds(to - belief_.stamp));
    const int core = layout_.core_size();
    const int pose = core / 2;
    ErrorMatrix G = F.topLeftCorner(pose, core);
    G.diagonal().array() -= 1.0;
    auto cross = cross_.topRows(size_);
    auto W = W_.topLeftCorner(size_, pose);
    W.noalias() = cross.leftCols(core) * G.transpose();
    cross.leftCols(pose) += W;
    distant_.change(G);
    for (int i = core; i < layout_.size(); ++i) {
      if (F(i, i) == 1.0) continue;
      cross.col(i) *= F(i, i);
      distant_.scale(i, F(i, i));
    }
  }
  process.predict(belief_, to, standing);
}

void JointGaussian::update(const Linearization& model, const estimation::StateJacobian& H) {
  const int rows = model.rows();
  Factor own = Factor::Zero(layout_.size(), rows);
  for (int k = 0; k < H.count; ++k) {
    own += belief_.P.col(H.states[static_cast<std::size_t>(k)]) * H.columns.col(k).transpose();
  }
  Square S = model.R;
  for (int k = 0; k < H.count; ++k) {
    S += H.columns.col(k) * own.row(H.states[static_cast<std::size_t>(k)]);
  }
  const Eigen::LLT<Square> factor(0.5 * (S + S.transpose()));
  if (!S.allFinite() || !model.residual.allFinite() || factor.info() != Eigen::Success) return;
  auto W = W_.topLeftCorner(size_, rows);
  W.setZero();
  distant_.begin_update(rows);
  for (int k = 0; k < H.count; ++k) {
    W += cross_.topRows(size_).col(H.states[static_cast<std::size_t>(k)]) * H.columns.col(k).transpose();
    distant_.measure_state(H.states[static_cast<std::size_t>(k)], H.columns.col(k));
  }
  divide(own, factor);
  divide(W, factor);
  // The optimal update, except for states that are considered and not estimated (Schmidt): their own covariance stays.
  const int first = H.first_considered;
  const ErrorMatrix kept = belief_.P.block(first, first, H.considered, H.considered);
  subtract(own);
  belief_.P.block(first, first, H.considered, H.considered) = kept;
  gaussian::Vector white = model.residual;
  factor.matrixL().solveInPlace(white);
  distant_.update(factor, own, W, white);
  correct(own, white, first, H.considered);
}

void JointGaussian::relate(const Column& nu, const Rows& H_pose, std::initializer_list<NodeRows> nodes,
                           const std::array<int, 3>& pose, double gate) {
  for (const NodeRows& part : nodes) approach(part.node);
  ++relations_;
  const auto rows = static_cast<int>(H_pose.rows());
  Factor own = Factor::Zero(layout_.size(), rows);
  auto W = W_.topLeftCorner(size_, rows);
  W.setZero();
  distant_.begin_update(rows);
  for (int i = 0; i < 3; ++i) {
    const int state = pose[static_cast<std::size_t>(i)];
    own += belief_.P.col(state) * H_pose.col(i).transpose();
    W += cross_.topRows(size_).col(state) * H_pose.col(i).transpose();
    distant_.measure_state(state, H_pose.col(i));
  }
  const auto pending = pending_.topLeftCorner(size_, pending_columns_);
  for (const NodeRows& part : nodes) {
    const auto [id, offset, size, used, is_near] = find(part.node);
    distant_.measure_near(offset, part.H);
    own += cross_.middleRows(offset, size).transpose() * part.H.transpose();
    W.noalias() += between_.block(0, offset, size_, size) * part.H.transpose();
    W.noalias() -= pending * (pending.middleRows(offset, size).transpose() * part.H.transpose());
  }
  Square S = Square::Identity(rows, rows);
  for (int i = 0; i < 3; ++i) S += H_pose.col(i) * own.row(pose[static_cast<std::size_t>(i)]);
  for (const NodeRows& part : nodes) {
    const auto [id, offset, size, used, is_near] = find(part.node);
    S += part.H * W.middleRows(offset, size);
  }
  const Eigen::LLT<Square> factor(0.5 * (S + S.transpose()));
  if (!S.allFinite() || !nu.allFinite() || factor.info() != Eigen::Success) return;
  gaussian::Vector white = nu;
  factor.matrixL().solveInPlace(white);
  if (white.squaredNorm() > gate) return;
  divide(own, factor);
  divide(W, factor);
  subtract(own);
  distant_.update(factor, own, W, white);
  correct(own, white, 0, 0);
}

JointGaussian::Column JointGaussian::take_correction(NodeId node) {
  approach(node);
  Column correction = pending_correction(node);
  const Node& place = find(node);
  corrections_.segment(place.offset, place.size).setZero();
  return correction;
}

JointGaussian::Column JointGaussian::pending_correction(NodeId node) const {
  const Node& place = find(node);
  if (!place.is_near) return distant_.corrections(place.offset, place.size);
  return corrections_.segment(place.offset, place.size);
}

void JointGaussian::subtract(const Factor& own) {
  belief_.P -= own.lazyProduct(own.transpose());
  for (int i = 0; i < layout_.size(); ++i) belief_.P(i, i) = std::max(belief_.P(i, i), 0.0);
  if (size_ == 0) return;
  const auto rows = static_cast<int>(own.cols());
  const auto W = W_.topLeftCorner(size_, rows);
  cross_.topRows(size_).noalias() -= W * own.transpose();
  if (pending_columns_ + rows > kPending) subtract_pending();
  pending_.block(0, pending_columns_, size_, rows) = W;
  pending_columns_ += rows;
}

void JointGaussian::subtract_pending() {
  if (pending_columns_ == 0) return;
  const auto pending = pending_.topLeftCorner(size_, pending_columns_);
  auto between = between_.topLeftCorner(size_, size_);
  between.selfadjointView<Eigen::Lower>().rankUpdate(pending, -1.0);
  between.triangularView<Eigen::StrictlyUpper>() = between.transpose();
  pending_columns_ = 0;
}

void JointGaussian::reserve(int size) {
  const auto capacity = static_cast<int>(between_.rows());
  if (size <= capacity) return;
  const int more = std::max(size, 2 * capacity);
  cross_.conservativeResize(more, layout_.size());
  between_.conservativeResize(more, more);
  pending_.conservativeResize(more, kPending);
  corrections_.conservativeResize(more);
  W_.resize(more, kMaxUpdateRows);
}

JointGaussian::NodeId JointGaussian::add_node(const Rows& G, const Rows& Q, const std::array<int, 3>& pose) {
  const auto size = static_cast<int>(G.rows());
  if (size_ + size > limits_.most) choose_near(nullptr);
  const int offset = size_;
  reserve(offset + size);
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxErrorStates> P_pose(3, layout_.size());
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, Eigen::Dynamic, 3> of_nodes(offset, 3);
  for (int i = 0; i < 3; ++i) {
    const int state = pose[static_cast<std::size_t>(i)];
    P_pose.row(i) = belief_.P.row(state);
    of_nodes.col(i) = cross_.topRows(offset).col(state);
    for (int j = 0; j < 3; ++j) P(i, j) = belief_.P(state, pose[static_cast<std::size_t>(j)]);
  }
  cross_.middleRows(offset, size) = G * P_pose;
  between_.block(0, offset, offset, size) = of_nodes * G.transpose();
  between_.block(offset, 0, size, offset) = between_.block(0, offset, offset, size).transpose();
  between_.block(offset, offset, size, size) = G * P * G.transpose() + Q;
  pending_.middleRows(offset, size).setZero();
  corrections_.segment(offset, size).setZero();
  distant_.add_near(G, pose);
  size_ += size;
  nodes_.push_back({next_id_, offset, size, relations_});
  return next_id_++;
}

bool JointGaussian::has_node(NodeId node) const { return std::ranges::binary_search(nodes_, node, {}, &Node::id); }

const JointGaussian::Node& JointGaussian::find(NodeId node) const {
  return *std::ranges::lower_bound(nodes_, node, {}, &Node::id);
}

void JointGaussian::remove_node(NodeId node) {
  const auto found = std::ranges::lower_bound(nodes_, node, {}, &Node::id);
  const auto [id, offset, size, used, is_near] = *found;
  if (is_near) {
    subtract_pending();
    for (int i = offset; i + size < size_; ++i) {
      cross_.row(i) = cross_.row(i + size);
      corrections_[i] = corrections_[i + size];
      between_.row(i).head(size_) = between_.row(i + size).head(size_);
    }
    size_ -= size;
    for (int i = offset; i < size_; ++i) between_.col(i).head(size_) = between_.col(i + size).head(size_);
    distant_.remove_near(offset, size);
  } else {
    distant_.remove(offset, size);
  }
  for (auto later = nodes_.erase(found); later != nodes_.end(); ++later) {
    if (later->is_near == is_near) later->offset -= size;
  }
}

JointGaussian::Rows JointGaussian::node_covariance(NodeId node) const {
  const auto [id, offset, size, used, is_near] = find(node);
  if (!is_near) return distant_.covariance(offset, size);
  const auto pending = pending_.block(offset, 0, size, pending_columns_);
  return between_.block(offset, offset, size, size) - pending * pending.transpose();
}

Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, kMaxErrorStates> JointGaussian::cross_covariance(
    NodeId node) const {
  const auto [id, offset, size, used, is_near] = find(node);
  if (!is_near) return distant_.cross(offset, size).transpose();
  return cross_.middleRows(offset, size);
}

Eigen::Matrix3d JointGaussian::covariance_against(NodeId node, const Eigen::Matrix3d& T) const {
  const Eigen::Matrix3d cross = T * cross_covariance(node)(Eigen::all, layout_.pose_indices());
  return pose_covariance(belief_, layout_) + T * node_covariance(node) * T.transpose() - cross - cross.transpose();
}

void JointGaussian::approach(NodeId node) {
  Node& found = *std::ranges::lower_bound(nodes_, node, {}, &Node::id);
  if (!found.is_near) choose_near(&found);
  found.used = relations_;
}

void JointGaussian::choose_near(const Node* needed) {
  std::vector<Node*> by_use;
  by_use.reserve(nodes_.size());
  for (Node& node : nodes_) by_use.push_back(&node);
  int kept = 0;
  const auto keep_until = [&](int limit) {
    for (Node* node : by_use) {
      if (node->is_near || kept + node->size > limit) continue;
      node->is_near = true;
      kept += node->size;
    }
  };
  const std::uint64_t about = needed != nullptr ? needed->used : relations_;
  join_distant();
  for (Node& node : nodes_) node.is_near = false;
  std::ranges::stable_sort(by_use, std::ranges::greater(), &Node::used);
  keep_until(needed != nullptr ? limits_.kept / 2 : limits_.kept);
  std::ranges::stable_sort(
      by_use, {}, [about](const Node* node) { return std::max(node->used, about) - std::min(node->used, about); });
  if (needed != nullptr)
    std::stable_partition(by_use.begin(), by_use.end(), [needed](const Node* node) { return node == needed; });
  keep_until(limits_.kept);
  part_distant();
}

void JointGaussian::join_distant() {
  subtract_pending();
  if (distant_.empty()) return;
  const int near = size_;
  const int distant = distant_.size();
  const int states = layout_.size();
  reserve(near + distant);
  const Eigen::MatrixXd C = distant_.cross();
  cross_.middleRows(near, distant) = C.topRows(states).transpose();
  between_.block(0, near, near, distant) = C.bottomRows(near);
  between_.block(near, 0, distant, near) = C.bottomRows(near).transpose();
  between_.block(near, near, distant, distant) = distant_.covariance();
  corrections_.segment(near, distant) = distant_.corrections();
  distant_.clear();
  size_ = near + distant;
  for (Node& node : nodes_) {
    if (!node.is_near) node.offset += near;
  }
}

void JointGaussian::part_distant() {
  std::vector<int> order;  // of the error states: the near ones first
  order.reserve(static_cast<std::size_t>(size_));
  int near = 0;
  for (const bool is_near : {true, false}) {
    for (Node& node : nodes_) {
      if (node.is_near != is_near) continue;
      const int from = node.offset;
      node.offset = static_cast<int>(order.size()) - (is_near ? 0 : near);
      for (int i = 0; i < node.size; ++i) order.push_back(from + i);
    }
    if (is_near) near = static_cast<int>(order.size());
  }
  const int states = layout_.size();
  const int distant = size_ - near;
  const Eigen::MatrixXd between = between_(order, order);
  const Eigen::MatrixXd cross = cross_(order, Eigen::all);
  const Eigen::VectorXd corrections = corrections_(order);
  Eigen::MatrixXd C(states + near, distant);
  C.topRows(states) = cross.bottomRows(distant).transpose();
  C.bottomRows(near) = between.topRightCorner(near, distant);
  distant_.begin(std::move(C), between.bottomRightCorner(distant, distant), corrections.tail(distant), states);
  size_ = near;
  cross_.topRows(near) = cross.topRows(near);
  between_.topLeftCorner(near, near) = between.topLeftCorner(near, near);
  corrections_.head(near) = corrections.head(near);
}

}  // namespace waymark::joint
