// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <span>
#include <vector>

#include "estimation/process_model.hpp"
#include "estimation/state_jacobian.hpp"
#include "joint/distant_nodes.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::joint {

/// With more error states of near nodes than `most`, those that were not used for long become distant: `kept` stay.
struct NearLimits {
  int most = 300;
  int kept = 150;
};

/// One Gaussian over the navigation state and the nodes of a map: EKF-SLAM (R. Smith, M. Self, P. Cheeseman, 1990;
/// docs/math/joint.md). Nodes are static, of one to three error states each. Their means and the meaning of their
/// errors are the caller's, who fetches their corrections. Of many nodes those that were not used for long are distant
/// ones: what an update takes grows with the square of the others.
class WAYMARK_API JointGaussian {
 public:
  /// Rows of a relation over three states of the pose, or over one node.
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;

  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;
  /// Names a node for as long as it lives.
  using NodeId = std::uint64_t;

  /// A relation's part of one node: H over the node's states.
  struct NodeRows {
    NodeId node;
    Rows H;
  };

  /// `layout` must outlive the object.
  explicit JointGaussian(const StateLayout& layout, NearLimits limits = {}) : layout_(layout), limits_(limits) {}

  /// The navigation state alone, without nodes.
  void start(const Belief& prior);
  /// The navigation state begins anew, uncorrelated with the nodes, which stay.
  void restart(const Belief& belief);
  /// All begins anew, but for the names of `kept`: nodes of three states, by ascending names. All others are gone.
  /// `cross`: of their states with (x, y, yaw); `between`: covariance of their states.
  void restart(const Belief& belief, std::span<const NodeId> kept,
               const Eigen::Matrix<double, Eigen::Dynamic, 3>& cross, const Eigen::MatrixXd& between);

  /// Predicts to `to`; the mean must be the one at the belief's stamp.
  void predict(const estimation::ProcessModel& process, Time to, bool standing);
  /// Updates with a model that was linearised at the mean. No effect if the innovation's covariance is not positive
  /// definite.
  void update(const Linearization& model, const estimation::StateJacobian& H);
  /// Updates with a relation between (x, y, yaw) and nodes, whose noise is white: ν = H_pose δ + Σ H_i δ_i + N(0, I).
  void relate(const Column& nu, const Rows& H_pose, std::initializer_list<NodeRows> nodes) {
    relate(nu, H_pose, nodes, layout_.pose_indices(), kNoGate);
  }
  /// The same, unless the squared Mahalanobis length of the innovation is beyond `gate`.
  void relate_within(double gate, const Column& nu, const Rows& H_pose, std::initializer_list<NodeRows> nodes) {
    relate(nu, H_pose, nodes, layout_.pose_indices(), gate);
  }
  /// The same over other three error states of the pose.
  void relate(const Column& nu, const Rows& H_pose, std::initializer_list<NodeRows> nodes,
              const std::array<int, 3>& pose) {
    relate(nu, H_pose, nodes, pose, kNoGate);
  }
  /// The correction of a node's mean since the last call for it, in its error states.
  Column take_correction(NodeId node);
  /// The same, without taking it.
  Column pending_correction(NodeId node) const;

  /// Adds a node δ = G · (δx, δy, δyaw) + N(0, Q).
  NodeId add_node(const Rows& G, const Rows& Q) { return add_node(G, Q, layout_.pose_indices()); }
  /// The same of other three error states of the pose.
  NodeId add_node(const Rows& G, const Rows& Q, const std::array<int, 3>& pose);
  /// Removes a node: it is marginalised.
  void remove_node(NodeId node);
  bool has_node(NodeId node) const;
  /// Covariance of one node.
  Rows node_covariance(NodeId node) const;
  /// Covariance of one node with the navigation state: states of the node × error states.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, kMaxErrorStates> cross_covariance(NodeId node) const;
  /// Covariance of (δx, δy, δyaw) − T δ, with δ the three states of a node.
  Eigen::Matrix3d covariance_against(NodeId node, const Eigen::Matrix3d& T) const;
  /// Number of error states of all nodes, and of those that are not distant.
  int size() const { return size_ + distant_.size(); }
  int near_size() const { return size_; }

  /// The marginal of the navigation state.
  const Belief& belief() const { return belief_; }
  /// Changes the navigation state's own covariance, by noise alone.
  template <class Change>
  void add_noise(const Change& change) {
    change(belief_);
  }
  /// Makes velocity and rate uncorrelated with the nodes, and applies `change`, which does so for the navigation state.
  template <class Change>
  void replace_twist(const Change& change) {
    for (int core = 6; core < kCoreStates; ++core) {
      const int i = layout_.active(core);
      if (i < 0) continue;
      cross_.topRows(size_).col(i).setZero();
      distant_.scale(i, 0.0);
    }
    change(belief_);
  }

  template <class Archive>
  void serialize(Archive& archive);

 private:
  using Factor = DistantNodes::Factor;
  static constexpr double kNoGate = std::numeric_limits<double>::infinity();

  struct Node {
    NodeId id;
    int offset;  // among the near ones, or among the distant ones
    int size;
    std::uint64_t used;  // when a relation had it last
    bool is_near = true;
  };
  const Node& find(NodeId node) const;
  static constexpr int kPending = 32;
  /// Room at first: Eigen does not look at blocks without rows of matrices without memory.
  static constexpr int kFirstStates = 24;

  void relate(const Column& nu, const Rows& H_pose, std::initializer_list<NodeRows> nodes,
              const std::array<int, 3>& pose, double gate);
  /// A distant node becomes a near one, and with it those that were used at the same time.
  void approach(NodeId node);
  /// Decides anew which nodes are near: those used last, and those used about the time of `needed`.
  void choose_near(const Node* needed);
  /// All nodes become near ones.
  void join_distant();
  /// The nodes marked so become distant; none is before.
  void part_distant();
  void reserve(int size);
  /// Subtracts W Wᵀ, W = (own; of_nodes): of the nodes' block later, many columns at once.
  void subtract(const Factor& own);
  /// Corrects the means by W · `white`, except for `considered` states of the navigation state.
  void correct(const Factor& own, const gaussian::Vector& white, int first_considered, int considered);
  void subtract_pending();

  const StateLayout& layout_;
  NearLimits limits_;
  Belief belief_;
  std::vector<Node> nodes_;  // ids ascend
  NodeId next_id_ = 0;
  std::uint64_t relations_ = 0;
  DistantNodes distant_;
  int size_ = 0;             // error states of the near nodes; the matrices below have room for more
  Eigen::MatrixXd cross_;    // nodes × navigation states
  Eigen::MatrixXd between_;  // nodes × nodes, without the pending part
  Eigen::MatrixXd pending_;  // nodes × kPending: between_ − pending_ pending_ᵀ is the covariance
  int pending_columns_ = 0;
  Eigen::VectorXd corrections_;  // of the nodes' means, not fetched yet
  Eigen::MatrixXd W_;            // scratch: nodes × rows of an update
};

}  // namespace waymark::joint
