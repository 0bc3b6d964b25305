// SPDX-License-Identifier: Apache-2.0
#include "joint/distant_nodes.hpp"

#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::joint {

namespace {

void remove_rows(Eigen::MatrixXd& matrix, Eigen::Index first, Eigen::Index count) {
  for (Eigen::Index i = first; i + count < matrix.rows(); ++i) matrix.row(i) = matrix.row(i + count);
  matrix.conservativeResize(matrix.rows() - count, Eigen::NoChange);
}

void remove_columns(Eigen::MatrixXd& matrix, Eigen::Index first, Eigen::Index count) {
  for (Eigen::Index i = first; i + count < matrix.cols(); ++i) matrix.col(i) = matrix.col(i + count);
  matrix.conservativeResize(Eigen::NoChange, matrix.cols() - count);
}

}  // namespace

void DistantNodes::begin(Eigen::MatrixXd C, Eigen::MatrixXd D, Eigen::VectorXd c, int states) {
  states_ = states;
  C_ = std::move(C);
  D_ = std::move(D);
  c_ = std::move(c);
  const auto near = C_.rows();
  Phi_.setIdentity(near, near);
  Psi_.setZero(near, near);
  theta_.setZero(near);
}

void DistantNodes::change(const ErrorMatrix& G) {
  if (!empty()) Phi_.topRows(G.rows()) += (G * Phi_.topRows(G.cols())).eval();
}

void DistantNodes::scale(int state, double factor) {
  if (!empty()) Phi_.row(state) *= factor;
}

void DistantNodes::add(int state, double factor, int other) {
  if (!empty()) Phi_.row(state) += factor * Phi_.row(other);
}

void DistantNodes::forget_navigation() {
  if (!empty()) Phi_.topRows(states_).setZero();
}

void DistantNodes::remove_near(int offset, int size) {
  if (!empty()) remove_rows(Phi_, states_ + offset, size);
}

void DistantNodes::begin_update(int rows) {
  if (!empty()) seen_.setZero(rows, Phi_.cols());
}

Eigen::MatrixXd DistantNodes::covariance(int offset, int size) const {
  const auto C = C_.middleCols(offset, size);
  Eigen::MatrixXd P = D_.block(offset, offset, size, size);
  P.noalias() -= C.transpose() * (Psi_ * C);
  return P;
}

Eigen::VectorXd DistantNodes::corrections(int offset, int size) const {
  return c_.segment(offset, size) + C_.middleCols(offset, size).transpose() * theta_;
}

void DistantNodes::remove(int offset, int size) {
  remove_columns(C_, offset, size);
  remove_columns(D_, offset, size);
  remove_rows(D_, offset, size);
  for (Eigen::Index i = offset; i + size < c_.size(); ++i) c_[i] = c_[i + size];
  c_.conservativeResize(c_.size() - size);
}

template <class Archive>
void DistantNodes::serialize(Archive& archive, int states, int near) {
  archive.section("distant_nodes", 1);
  archive(C_, D_, c_, Phi_, Psi_, theta_);
  if constexpr (Archive::kReads) {
    states_ = states;
    const auto before = C_.rows();
    const bool fits = D_.cols() == D_.rows() && C_.cols() == D_.rows() && c_.size() == D_.rows() &&
                      (empty() || (Phi_.rows() == states + near && before >= states)) && Phi_.cols() == before &&
                      Psi_.rows() == before && Psi_.cols() == before && theta_.size() == before && C_.allFinite() &&
                      D_.allFinite() && c_.allFinite() && Phi_.allFinite() && Psi_.allFinite() && theta_.allFinite();
    if (!fits) throw DataError("the checkpoint has distant nodes that do not fit its joint Gaussian");
  }
}
template void DistantNodes::serialize(OutArchive& archive, int states, int near);
template void DistantNodes::serialize(InArchive& archive, int states, int near);

}  // namespace waymark::joint
