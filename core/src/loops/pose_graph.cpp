// SPDX-License-Identifier: Apache-2.0
#include "loops/pose_graph.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "loops/twist.hpp"

namespace waymark::loops {

namespace {

constexpr int kMostIterations = 20;
/// In the first iterations loops keep their weight farther off, by powers of this factor: new ones begin far from their
/// places, and while they pull, old ones are far from theirs.
constexpr double kAnneal = 4.0;
constexpr int kAnnealed = 6;             // iterations
constexpr double kConverged = 1e-4;      // [m, rad]
constexpr double kRobust = 15.0;         // χ² of a loop that keeps a fourth of its weight
constexpr double kAgreement = 11.3;      // χ² of two loops, 99 % of three degrees of freedom
constexpr double kLeastVariance = 1e-8;  // [m², rad²]
/// A turn counts as the motion of a point so far away, where ways are compared [m].
constexpr double kTurnArm = 10.0;

Eigen::Matrix3d information(const Eigen::Matrix3d& P) {
  return (P + kLeastVariance * Eigen::Matrix3d::Identity()).inverse();
}

/// The noise of a relation as a motion of the whole map.
Eigen::Matrix3d as_twist(const Eigen::Matrix3d& P, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Matrix3d G = twist_of_error(to.head<2>()) * turn(from.z());
  return G * P * G.transpose();
}

/// between(a, b) ⊟ z and its derivatives by the poses a and b.
struct Residual {
  Eigen::Vector3d r;
  Eigen::Matrix3d by_a;
  Eigen::Matrix3d by_b;
};

Residual residual(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& z) {
  const Eigen::Vector3d ab = between(a, b);
  Residual residual{difference(ab, z), -Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  const Eigen::Matrix2d R = rotation(a.z()).transpose();
  residual.by_a.topLeftCorner<2, 2>() = -R;
  residual.by_a(0, 2) = ab.y();
  residual.by_a(1, 2) = -ab.x();
  residual.by_b.topLeftCorner<2, 2>() = R;
  return residual;
}

double robust_weight(double chi_squared, int iteration) {
  const double scale = kRobust * std::pow(kAnneal, std::max(0, kAnnealed - iteration));
  const double root = scale / (scale + chi_squared);
  return root * root;
}

/// The normal equations; node 0 is fixed and has no rows.
class NormalEquations {
 public:
  explicit NormalEquations(std::size_t nodes)
      : rows_(3 * (static_cast<Eigen::Index>(nodes) - 1)), gradient_(Eigen::VectorXd::Zero(rows_)) {}

  void add(std::size_t a, std::size_t b, const Residual& e, const Eigen::Matrix3d& information) {
    add_block(a, a, e.by_a.transpose() * information * e.by_a);
    add_block(b, b, e.by_b.transpose() * information * e.by_b);
    // The lower triangle alone.
    if (a < b) {
      add_block(b, a, e.by_b.transpose() * information * e.by_a);
    } else {
      add_block(a, b, e.by_a.transpose() * information * e.by_b);
    }
    add_rows(a, e.by_a.transpose() * information * e.r);
    add_rows(b, e.by_b.transpose() * information * e.r);
  }

  /// Empty if the equations have no solution.
  Eigen::VectorXd solve() const {
    const Factor factor(matrix());
    if (factor.info() != Eigen::Success) return {};
    return factor.solve(-gradient_);
  }

  /// The inverse's rows and columns of these nodes; empty as above.
  Eigen::MatrixXd covariance(std::span<const std::size_t> nodes) const {
    const auto count = static_cast<Eigen::Index>(nodes.size());
    const Factor factor(matrix());
    if (factor.info() != Eigen::Success) return {};
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(3 * count, 3 * count);
    for (Eigen::Index column = 0; column < count; ++column) {
      const std::size_t node = nodes[static_cast<std::size_t>(column)];
      if (node == 0) continue;
      Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(rows_, 3);
      unit.middleRows<3>(first_row(node)).setIdentity();
      const Eigen::MatrixXd of_all = factor.solve(unit);
      for (Eigen::Index row = 0; row < count; ++row) {
        const std::size_t other = nodes[static_cast<std::size_t>(row)];
        if (other > 0) P.block<3, 3>(3 * row, 3 * column) = of_all.middleRows<3>(first_row(other));
      }
    }
    return P;
  }

 private:
  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

  Eigen::SparseMatrix<double> matrix() const {
    Eigen::SparseMatrix<double> H(rows_, rows_);
    H.setFromTriplets(triplets_.begin(), triplets_.end());
    return H;
  }
  static Eigen::Index first_row(std::size_t node) { return 3 * (static_cast<Eigen::Index>(node) - 1); }
  void add_block(std::size_t a, std::size_t b, const Eigen::Matrix3d& block) {
    if (a == 0 || b == 0) return;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        triplets_.emplace_back(static_cast<int>(first_row(a)) + row, static_cast<int>(first_row(b)) + column,
                               block(row, column));
    }
  }
  void add_rows(std::size_t node, const Eigen::Vector3d& rows) {
    if (node > 0) gradient_.segment<3>(first_row(node)) += rows;
  }

  Eigen::Index rows_;
  Eigen::VectorXd gradient_;
  std::vector<Eigen::Triplet<double>> triplets_;
};

}  // namespace

double PoseGraph::chi_squared(const Loop& loop, std::span<const Eigen::Vector3d> poses) {
  const Eigen::Vector3d r = residual(poses[loop.from], poses[loop.to], loop.relation.z).r;
  return r.dot(information(loop.relation.P) * r);
}

/// What a relation says about motions of the whole map depends on the difference of two nodes alone, so the noise of
/// steps in a row adds up, and nodes that nobody asks for drop out.
Eigen::MatrixXd PoseGraph::covariance(std::span<const Eigen::Vector3d> poses,
                                      std::span<const std::size_t> nodes) const {
  const Residual of_difference{Eigen::Vector3d::Zero(), -Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  std::vector<std::size_t> kept{0};
  kept.insert(kept.end(), nodes.begin(), nodes.end());
  for (const Loop& loop : loops_) kept.insert(kept.end(), {loop.from, loop.to});
  std::ranges::sort(kept);
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  const auto place = [&](std::size_t node) {
    return static_cast<std::size_t>(std::ranges::lower_bound(kept, node) - kept.begin());
  };
  NormalEquations equations(kept.size());
  for (std::size_t i = 0; i + 1 < kept.size(); ++i) {
    Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
    for (std::size_t k = kept[i]; k < kept[i + 1]; ++k) P += as_twist(steps_[k].P, poses[k], poses[k + 1]);
    equations.add(i, i + 1, of_difference, information(P));
  }
  for (const Loop& loop : loops_) {
    const Eigen::Matrix3d P = as_twist(loop.relation.P, poses[loop.from], poses[loop.to]);
    equations.add(place(loop.from), place(loop.to), of_difference,
                  robust_weight(chi_squared(loop, poses), kAnnealed) * information(P));
  }
  std::vector<std::size_t> places;
  places.reserve(nodes.size());
  for (const std::size_t node : nodes) places.push_back(place(node));
  return equations.covariance(places);
}

void PoseGraph::solve(std::vector<Eigen::Vector3d>& poses) const {
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    NormalEquations equations(size());
    for (std::size_t k = 0; k + 1 < size(); ++k)
      equations.add(k, k + 1, residual(poses[k], poses[k + 1], steps_[k].z), information(steps_[k].P));
    for (const Loop& loop : loops_) {
      const Eigen::Matrix3d full = information(loop.relation.P);
      const Residual e = residual(poses[loop.from], poses[loop.to], loop.relation.z);
      equations.add(loop.from, loop.to, e, robust_weight(e.r.dot(full * e.r), iteration) * full);
    }
    const Eigen::VectorXd change = equations.solve();
    if (change.size() == 0 || !change.allFinite()) return;
    for (std::size_t k = 1; k < size(); ++k) {
      poses[k] += change.segment<3>(3 * (static_cast<Eigen::Index>(k) - 1));
      poses[k].z() = so3::wrap(poses[k].z());
    }
    if (iteration > kAnnealed && change.cwiseAbs().maxCoeff() < kConverged) return;
  }
}

std::vector<Relation> PoseGraph::relations_from(std::size_t node) const {
  std::vector<std::vector<const Loop*>> loops_at(size());
  for (const Loop& loop : loops_) {
    loops_at[loop.from].push_back(&loop);
    loops_at[loop.to].push_back(&loop);
  }
  const auto cost = [](const Relation& step) {
    return std::max(0.0, position_variance(step.P) + kTurnArm * kTurnArm * step.P(2, 2));
  };
  std::vector<Relation> relations(size());
  std::vector<double> costs(size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  costs[node] = 0.0;
  open.emplace(0.0, node);
  while (!open.empty()) {
    const double so_far = open.top().first;
    const std::size_t at = open.top().second;
    open.pop();
    if (so_far > costs[at]) continue;
    const auto reach = [&](std::size_t next, const Relation& step) {
      const double next_cost = so_far + cost(step);
      if (!(next_cost < costs[next])) return;
      costs[next] = next_cost;
      relations[next] = compose(relations[at], step);
      open.emplace(next_cost, next);
    };
    if (at + 1 < size()) reach(at + 1, steps_[at]);
    if (at > 0) reach(at - 1, inverse(steps_[at - 1]));
    for (const Loop* loop : loops_at[at]) {
      if (loop->from == at) {
        reach(loop->to, loop->relation);
      } else {
        reach(loop->from, inverse(loop->relation));
      }
    }
  }
  return relations;
}

namespace {

/// The relation of two nodes by the path alone.
Relation along(std::span<const Relation> steps, std::size_t a, std::size_t b) {
  Relation along;
  for (std::size_t k = std::min(a, b); k < std::max(a, b); ++k) along = compose(along, steps[k]);
  return a <= b ? along : inverse(along);
}

/// From one old place, by its loop to the new ones and by the other loop back, to the other old place.
bool agree(const Loop& one, const Loop& other, std::span<const Relation> steps) {
  const Relation around = compose(compose(one.relation, along(steps, one.to, other.to)), inverse(other.relation));
  const Relation direct = along(steps, one.from, other.from);
  const Eigen::Vector3d off = difference(around.z, direct.z);
  return off.dot((around.P + direct.P).inverse() * off) < kAgreement;
}

}  // namespace

std::vector<std::size_t> agreeing(std::span<const Loop> loops, std::span<const Relation> steps) {
  const std::size_t count = loops.size();
  std::vector<std::vector<bool>> fits(count, std::vector<bool>(count, false));
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = i + 1; k < count; ++k) fits[i][k] = fits[k][i] = agree(loops[i], loops[k], steps);
  }
  std::vector<std::size_t> best;
  for (std::size_t first = 0; first < count; ++first) {
    std::vector<std::size_t> set{first};
    for (std::size_t k = 0; k < count; ++k) {
      const auto fits_with = [&](std::size_t member) { return fits[member][k]; };
      if (k != first && std::ranges::all_of(set, fits_with)) set.push_back(k);
    }
    if (set.size() > best.size()) best = set;
  }
  std::ranges::sort(best);
  return best;
}

}  // namespace waymark::loops
