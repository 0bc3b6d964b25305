// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/estimate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"

namespace waymark::calibration {

namespace {

constexpr int kMostIterations = 40;
constexpr int kFirstPaths = 3;            // iterations before the levels move
constexpr int kMovingReference = 8;       // iterations after which the path of the delays' velocities stays
constexpr double kSmallStep = 0.1;        // of σ: converged
constexpr double kSmallLevelStep = 0.05;  // of the logarithm of a level, or kSmallStep of its σ
constexpr double kLongestLevelStep = 1.0;
constexpr double kLevelPrior = 2.0;  // σ of the logarithm of a level that is no parameter
constexpr int kProbes = 16;
constexpr int kInformationProbes = 4;
constexpr int kBlocks = 20;  // of time, for the scatter of the scores
constexpr double kHuberShare = 0.99;
const char* const kNoSolution =
    "the equations of the calibration have no solution: they do not describe this log; waymark doctor checks its "
    "stamps";

using Solver = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>>;

/// Share of the squares of Gaussian residuals that is left under Huber's weights: E[n w(n)] / rows, for n ~ χ².
double share_under_weights(Eigen::Index rows) {
  const double bound = gaussian::chi_squared_quantile(kHuberShare, static_cast<int>(rows));
  // Over quantiles of n beyond the bound, each with the same probability.
  constexpr int kSteps = 200;
  double lost = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double q = kHuberShare + (1.0 - kHuberShare) * (i + 0.5) / kSteps;
    const double n = gaussian::chi_squared_quantile(q, static_cast<int>(rows));
    lost += (n - std::sqrt(bound * n)) * (1.0 - kHuberShare) / kSteps;
  }
  return 1.0 - lost / static_cast<double>(rows);
}

/// Weights the rows of outliers down, by the root of Huber's weight.
class Weights {
 public:
  Weights() {
    for (Eigen::Index rows = 1; rows <= 3; ++rows) {
      bounds_[rows] = gaussian::chi_squared_quantile(kHuberShare, static_cast<int>(rows));
      shares_[rows] = share_under_weights(rows);
    }
  }
  void apply(Rows& rows) const {
    Eigen::VectorXd roots = Eigen::VectorXd::Ones(rows.e.size());
    for (std::size_t m = 0; m + 1 < rows.of.size(); ++m) {
      const Eigen::Index count = rows.of[m + 1] - rows.of[m];
      const double squares = rows.e.segment(rows.of[m], count).squaredNorm();
      if (!std::isfinite(rows.t[static_cast<std::size_t>(rows.of[m])]) || squares <= bounds_[count]) continue;
      roots.segment(rows.of[m], count).setConstant(std::pow(bounds_[count] / squares, 0.25));
    }
    rows.e = rows.e.cwiseProduct(roots);
    rows.J = roots.asDiagonal() * rows.J;
  }
  /// Of the squares of one row of a measurement with so many.
  double share(Eigen::Index count) const { return shares_[count]; }

 private:
  double bounds_[4]{};
  double shares_[4]{};
};

Eigen::SparseMatrix<double> normal_equations(const Rows& rows) {
  Eigen::SparseMatrix<double> N = Eigen::SparseMatrix<double>(rows.J.transpose()) * rows.J;
  for (Eigen::Index i = 0; i < N.rows(); ++i) N.coeffRef(i, i) += 1e-9;
  return N;
}

void factorise(Solver& solver, const Rows& rows) {
  solver.compute(normal_equations(rows));
  if (solver.info() != Eigen::Success) throw Error(kNoSolution);
}

/// The part of y that the unknowns cannot explain: (I − J N⁻¹ Jᵀ) y.
Eigen::VectorXd residual_of(const Rows& rows, const Solver& solver, const Eigen::VectorXd& y) {
  const Eigen::VectorXd right = rows.J.transpose() * y;
  return y - rows.J * Eigen::VectorXd(solver.solve(right));
}

/// How the logarithm of each equation's variance depends on a level.
Eigen::VectorXd slopes_of(const Rows& rows, int level) {
  Eigen::VectorXd slopes = Eigen::VectorXd::Zero(rows.e.size());
  for (std::size_t i = 0; i < rows.noise.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (rows.noise[i].level[k] == level) slopes(static_cast<Eigen::Index>(i)) += rows.noise[i].slope[k];
    }
  }
  return slopes;
}

/// Signs by a fair coin, the same in every iteration.
Eigen::MatrixXd probes(Eigen::Index rows) {
  Random random({1, 0, 0, 0});
  Eigen::MatrixXd signs(rows, kProbes);
  for (Eigen::Index k = 0; k < signs.size(); ++k) signs(k) = random.uniform() < 0.5 ? -1.0 : 1.0;
  return signs;
}

/// Score and information of the logarithms of the levels.
struct LevelSlope {
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;
};

LevelSlope level_slope(const Rows& rows, const Solver& solver, const Weights& weights, const Eigen::MatrixXd& signs,
                       Eigen::Index count) {
  LevelSlope slope{Eigen::VectorXd::Zero(count), Eigen::MatrixXd::Zero(count, count)};
  Eigen::MatrixXd D(rows.e.size(), count);
  for (Eigen::Index g = 0; g < count; ++g) D.col(g) = slopes_of(rows, static_cast<int>(g));
  Eigen::VectorXd squares = rows.e.cwiseAbs2();
  for (std::size_t m = 0; m + 1 < rows.of.size(); ++m) {
    const Eigen::Index size = rows.of[m + 1] - rows.of[m];
    if (std::isfinite(rows.t[static_cast<std::size_t>(rows.of[m])]))
      squares.segment(rows.of[m], size) /= weights.share(size);
  }
  Eigen::VectorXd redundancy = Eigen::VectorXd::Zero(rows.e.size());
  for (Eigen::Index p = 0; p < kProbes; ++p) {
    const Eigen::VectorXd y = residual_of(rows, solver, signs.col(p));
    redundancy += y.cwiseProduct(signs.col(p)) / kProbes;
    if (p >= kInformationProbes) continue;
    for (Eigen::Index h = 0; h < count; ++h) {
      const Eigen::VectorXd u = residual_of(rows, solver, D.col(h).cwiseProduct(signs.col(p)));
      slope.information.col(h) += 0.5 / kInformationProbes * (D.transpose() * y.cwiseProduct(u));
    }
  }
  slope.information = (0.5 * (slope.information + slope.information.transpose())).eval();
  slope.gradient = 0.5 * (D.transpose() * (squares - redundancy));
  return slope;
}

/// The scatter of what blocks of time contribute to the parameters (their influence).
Eigen::MatrixXd scatter_of(const Rows& rows, const Eigen::MatrixXd& gain, double begin, double end) {
  const Eigen::MatrixXd influence = rows.J * gain;
  Eigen::MatrixXd blocks = Eigen::MatrixXd::Zero(gain.cols(), kBlocks);
  for (Eigen::Index i = 0; i < rows.e.size(); ++i) {
    const double t = rows.t[static_cast<std::size_t>(i)];
    if (!std::isfinite(t)) continue;
    const int block = std::clamp(static_cast<int>(kBlocks * (t - begin) / (end - begin)), 0, kBlocks - 1);
    blocks.col(block) += influence.row(i).transpose() * rows.e(i);
  }
  const Eigen::VectorXd mean = blocks.rowwise().mean();
  const Eigen::MatrixXd centred = blocks.colwise() - mean;
  return static_cast<double>(kBlocks) / (kBlocks - 1) * centred * centred.transpose();
}

/// The unknowns of an adjustment, and the state of its iterations.
class Adjustment {
 public:
  explicit Adjustment(const Equations& equations)
      : equations_(equations),
        columns_(static_cast<Eigen::Index>(equations.columns().size())),
        levels_(static_cast<Eigen::Index>(equations.levels().size())),
        prior_(columns_),
        x_(equations.start()),
        reference_(x_),
        log_levels_(Eigen::VectorXd::Zero(levels_)),
        level_sigma_(Eigen::VectorXd::Zero(levels_)),
        damping_(Eigen::VectorXd::Ones(levels_)),
        last_level_step_(Eigen::VectorXd::Zero(levels_)) {
    for (Eigen::Index k = 0; k < columns_; ++k) {
      const int index = equations.columns()[static_cast<std::size_t>(k)];
      prior_(k) = equations.parameters()[static_cast<std::size_t>(index)].prior_sigma;
    }
  }

  /// One step of the path and the parameters, then one of the levels. Returns whether both were small.
  bool iterate() {
    ++iterations_;
    if (iterations_ <= kMovingReference) reference_ = x_;
    Rows rows = equations_.linearize(x_, reference_, log_levels_);
    weights_.apply(rows);
    factorise(solver_, rows);
    const bool path_is_settled = step_path(rows);
    const bool levels_are_settled = step_levels(rows);
    return path_is_settled && levels_are_settled;
  }

  Estimate result() const {
    const auto parameters = static_cast<Eigen::Index>(equations_.parameters().size());
    Estimate result;
    result.change = Eigen::VectorXd::Zero(parameters);
    result.sigma = Eigen::VectorXd::Zero(parameters);
    result.information = Eigen::VectorXd::Zero(parameters);
    result.largest_step = largest_step_;
    result.iterations = iterations_;
    const auto set = [&](int index, double change, double sigma, double prior) {
      if (index < 0) return;
      result.change(index) = change;
      result.sigma(index) = sigma;
      result.information(index) = 1.0 - std::min(1.0, sigma * sigma / (prior * prior));
    };
    const Eigen::Index first = equations_.first_parameter();
    for (Eigen::Index k = 0; k < columns_; ++k)
      set(equations_.columns()[static_cast<std::size_t>(k)], x_(first + k), sigma_(k), prior_(k));
    for (Eigen::Index k = 0; k < levels_; ++k)
      set(equations_.levels()[static_cast<std::size_t>(k)], log_levels_(k), level_sigma_(k), kLevelPrior);
    return result;
  }

 private:
  /// Leaves in `rows` the residuals at the solution for the present levels.
  bool step_path(Rows& rows) {
    const Eigen::VectorXd right = rows.J.transpose() * rows.e;
    const Eigen::VectorXd step = -solver_.solve(right);
    if (!step.allFinite()) throw Error(kNoSolution);
    const Eigen::VectorXd of_parameters = step.segment(equations_.first_parameter(), columns_);
    const double too_far = std::max(1.0, (of_parameters.array().abs() / prior_.array()).maxCoeff());
    x_ += step / too_far;
    rows.e += rows.J * step;

    Eigen::MatrixXd selection = Eigen::MatrixXd::Zero(equations_.size(), columns_);
    selection.bottomRows(columns_).setIdentity();
    const Eigen::MatrixXd gain = solver_.solve(selection);
    const Eigen::MatrixXd covariance = gain.bottomRows(columns_);
    const auto [begin, end] = std::ranges::minmax(equations_.times());
    Eigen::MatrixXd sandwich = scatter_of(rows, gain, begin, end);
    sandwich += covariance * prior_.cwiseAbs2().cwiseInverse().asDiagonal() * covariance;
    sigma_ = covariance.diagonal().cwiseMax(sandwich.diagonal()).cwiseSqrt();
    largest_step_ = columns_ > 0 ? (of_parameters.array().abs() / sigma_.array()).maxCoeff() : 0.0;
    return largest_step_ < kSmallStep && iterations_ > kMovingReference;
  }

  /// They follow once the path fits.
  bool step_levels(const Rows& rows) {
    if (signs_.rows() != rows.e.size()) signs_ = probes(rows.e.size());
    const LevelSlope slope = level_slope(rows, solver_, weights_, signs_, levels_);
    const Eigen::VectorXd gradient = slope.gradient - log_levels_ / (kLevelPrior * kLevelPrior);
    Eigen::MatrixXd information = slope.information;
    information.diagonal().array() += 1.0 / (kLevelPrior * kLevelPrior);
    const Eigen::LDLT<Eigen::MatrixXd> solver(information);
    const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(levels_, levels_));
    level_sigma_ = covariance.diagonal().cwiseMax(1e-12).cwiseSqrt();
    if (iterations_ <= kFirstPaths) return false;
    Eigen::VectorXd step = solver.solve(gradient).cwiseMax(-kLongestLevelStep).cwiseMin(kLongestLevelStep);
    // Near zero a level's logarithm jumps back and forth about its place.
    for (Eigen::Index k = 0; k < levels_; ++k) damping_(k) *= step(k) * last_level_step_(k) < 0.0 ? 0.5 : 1.0;
    step = step.cwiseProduct(damping_);
    for (Eigen::Index k = 0; k < levels_; ++k) {
      if (equations_.is_bounded(k)) step(k) = std::max(step(k), -log_levels_(k));
    }
    last_level_step_ = step;
    log_levels_ += step;
    return ((step.array().abs() < kSmallLevelStep) || (step.array().abs() < kSmallStep * level_sigma_.array())).all();
  }

  const Equations& equations_;
  Eigen::Index columns_;
  Eigen::Index levels_;
  Eigen::VectorXd prior_;  // σ of the parameters
  Weights weights_;
  Solver solver_;
  Eigen::VectorXd x_;
  Eigen::VectorXd reference_;
  Eigen::VectorXd sigma_;
  Eigen::VectorXd log_levels_;
  Eigen::VectorXd level_sigma_;
  Eigen::VectorXd damping_;
  Eigen::VectorXd last_level_step_;
  Eigen::MatrixXd signs_;
  double largest_step_ = 0.0;
  int iterations_ = 0;
};

}  // namespace

Estimate estimate(const Equations& equations, const std::function<void(const Estimate&)>& progress) {
  Adjustment adjustment(equations);
  Estimate result;
  while (!result.converged && result.iterations < kMostIterations) {
    const bool is_settled = adjustment.iterate();
    result = adjustment.result();
    result.converged = is_settled;
    progress(result);
  }
  return result;
}

}  // namespace waymark::calibration
