// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::joint {

/// The nodes of a joint Gaussian of which nothing is measured for a while. What is measured of the near part x =
/// (navigation state, near nodes) reaches them by their covariance with x alone. So it is summed up in matrices of the
/// size of x, and carried out when a distant node is needed. Nothing is approximated: the compressed EKF (J. Guivant,
/// E. Nebot, IEEE Transactions on Robotics and Automation 17, 2001).
///
/// With C the covariance of x with the distant nodes d when they became distant, it is Φ C now, cov(d) is D − Cᵀ Ψ C,
/// and the correction of their mean is c + Cᵀ θ.
class WAYMARK_API DistantNodes {
 public:
  using Factor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxErrorStates, kMaxUpdateRows>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUpdateRows, kMaxUpdateRows>;

  void clear() { *this = DistantNodes(); }
  bool empty() const { return D_.rows() == 0; }
  int size() const { return static_cast<int>(D_.rows()); }

  /// They become distant. `C`: near × distant, the navigation state of `states` first; `D`: their covariance;
  /// `c`: corrections of their means that were not fetched.
  void begin(Eigen::MatrixXd C, Eigen::MatrixXd D, Eigen::VectorXd c, int states);

  // What happens to the near part. All without effect while there are none.

  /// The first error states of the navigation state change: δ += G (first ones).
  void change(const ErrorMatrix& G);
  /// One of them changes: δ_i ← factor · δ_i, or δ_i += factor · δ_j.
  void scale(int state, double factor);
  void add(int state, double factor, int other);
  /// The navigation state becomes uncorrelated with the nodes.
  void forget_navigation();
  /// A near node is added after the others, G · (three error states).
  template <class Rows, class States>
  void add_near(const Rows& G, const States& states) {
    if (empty()) return;
    const auto from = Phi_.rows();
    Phi_.conservativeResize(from + G.rows(), Eigen::NoChange);
    Phi_.bottomRows(G.rows()).setZero();
    for (Eigen::Index i = 0; i < G.cols(); ++i)
      Phi_.bottomRows(G.rows()) += G.col(i) * Phi_.row(states[static_cast<std::size_t>(i)]);
  }
  /// Near nodes' states are removed.
  void remove_near(int offset, int size);

  // An update of the near part, in this order: what it measures, and its effect.

  void begin_update(int rows);
  template <class Column>
  void measure_state(int state, const Column& H) {
    if (!empty()) seen_ += H * Phi_.row(state);
  }
  template <class Rows>
  void measure_near(int offset, const Rows& H) {
    if (!empty()) seen_.noalias() += H * Phi_.middleRows(states_ + offset, H.cols());
  }
  /// `factor`: L of S = L Lᵀ; `own`, `W`: P Hᵀ L⁻ᵀ of navigation state and near nodes; `white`: L⁻¹ ν.
  template <class Nodes, class White>
  void update(const Eigen::LLT<Square>& factor, const Factor& own, const Nodes& W, const White& white) {
    if (empty()) return;
    factor.matrixL().solveInPlace(seen_);
    Phi_.topRows(states_).noalias() -= own * seen_;
    Phi_.bottomRows(W.rows()).noalias() -= W * seen_;
    Psi_.noalias() += seen_.transpose() * seen_;
    theta_.noalias() += seen_.transpose() * white;
  }

  // The distant nodes now.

  Eigen::MatrixXd covariance() const { return covariance(0, size()); }
  Eigen::MatrixXd covariance(int offset, int size) const;
  /// Near × distant.
  Eigen::MatrixXd cross() const { return Phi_ * C_; }
  /// Navigation state × states of one node.
  Eigen::MatrixXd cross(int offset, int size) const { return Phi_.topRows(states_) * C_.middleCols(offset, size); }
  Eigen::VectorXd corrections() const { return corrections(0, size()); }
  Eigen::VectorXd corrections(int offset, int size) const;
  /// A distant node's states are removed.
  void remove(int offset, int size);

  /// Throws DataError if what a checkpoint has does not fit `states` and `near` error states.
  template <class Archive>
  void serialize(Archive& archive, int states, int near);

 private:
  int states_ = 0;  // of the navigation state
  Eigen::MatrixXd C_, D_;
  Eigen::VectorXd c_;
  Eigen::MatrixXd Phi_;  // near now × near when they became distant
  Eigen::MatrixXd Psi_;
  Eigen::VectorXd theta_;
  Eigen::MatrixXd seen_;  // scratch: H Φ
};

}  // namespace waymark::joint
