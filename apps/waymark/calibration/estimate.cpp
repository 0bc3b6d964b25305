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
constexpr int kMovingReference = 8;       // iterations after which the path of the delays' velocities stays
constexpr double kSmallStep = 0.1;        // of σ: converged
constexpr double kSmallLevelStep = 0.05;  // of the logarithm of a level, or kSmallStep of its σ
constexpr double kLongestLevelStep = 1.0;
constexpr double kLevelPrior = 2.0;  // σ of the logarithm of a level that is no parameter
constexpr int kProbes = 16;
constexpr int kInformationProbes = 4;
constexpr int kBlocks = 20;  // of time, for the scatter of the scores
constexpr double kHuberShare = 0.99;

using Solver = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>;

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

/// Weights the rows of outliers down, by the root of Huber's weight; returns the mean share of squares that is left.
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
  if (solver.info() != Eigen::Success) throw Error("the equations of the calibration have no solution");
}

/// The part of y that the unknowns cannot explain: (I − J N⁻¹ Jᵀ) y.
Eigen::VectorXd residual_of(const Rows& rows, const Solver& solver, const Eigen::VectorXd& y) {
  const Eigen::VectorXd right = rows.J.transpose() * y;
  return y - rows.J * Eigen::VectorXd(solver.solve(right));
}

/// A row for each level: how the logarithm of each equation's variance depends on it.
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

}  // namespace

Estimate estimate(const Equations& equations, const std::function<void(const Estimate&)>& progress) {
  const auto parameters = static_cast<Eigen::Index>(equations.parameters().size());
  const auto columns = static_cast<Eigen::Index>(equations.columns().size());
  const auto levels = static_cast<Eigen::Index>(equations.levels().size());
  const Eigen::Index first = equations.first_parameter();
  const auto parameter_of = [&](Eigen::Index column) -> const Parameter& {
    const int index = equations.columns()[static_cast<std::size_t>(column)];
    return equations.parameters()[static_cast<std::size_t>(index)];
  };
  Eigen::VectorXd prior(columns);
  for (Eigen::Index k = 0; k < columns; ++k) prior(k) = parameter_of(k).prior_sigma;

  const Weights weights;
  Estimate result;
  result.change = Eigen::VectorXd::Zero(parameters);
  result.sigma = Eigen::VectorXd::Zero(parameters);
  result.information = Eigen::VectorXd::Zero(parameters);
  Eigen::VectorXd x = equations.start();
  Eigen::VectorXd reference = x;
  Eigen::VectorXd log_levels = Eigen::VectorXd::Zero(levels);
  Eigen::VectorXd damping = Eigen::VectorXd::Ones(levels);
  Eigen::VectorXd last_level_step = Eigen::VectorXd::Zero(levels);
  Eigen::MatrixXd signs;
  Solver solver;
  while (!result.converged && result.iterations < kMostIterations) {
    ++result.iterations;
    if (result.iterations <= kMovingReference) reference = x;
    Rows rows = equations.linearize(x, reference, log_levels);
    weights.apply(rows);
    factorise(solver, rows);
    const Eigen::VectorXd right = rows.J.transpose() * rows.e;
    Eigen::VectorXd step = -solver.solve(right);
    if (!step.allFinite()) throw Error("the equations of the calibration have no solution");

    // σ of the parameters.
    Eigen::MatrixXd selection = Eigen::MatrixXd::Zero(equations.size(), columns);
    selection.bottomRows(columns).setIdentity();
    const Eigen::MatrixXd gain = solver.solve(selection);
    const Eigen::MatrixXd covariance = gain.bottomRows(columns);
    const Eigen::VectorXd of_parameters = step.segment(first, columns);
    const double too_far = std::max(1.0, (of_parameters.array().abs() / prior.array()).maxCoeff());
    x += step / too_far;
    rows.e += rows.J * step;  // at the solution for these levels
    const auto [begin, end] = std::ranges::minmax(equations.times());
    Eigen::MatrixXd sandwich = scatter_of(rows, gain, begin, end);
    sandwich += covariance * prior.cwiseAbs2().cwiseInverse().asDiagonal() * covariance;
    const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(sandwich.diagonal()).cwiseSqrt();

    result.largest_step = columns > 0 ? (of_parameters.array().abs() / sigma.array()).maxCoeff() : 0.0;
    bool is_settled = result.largest_step < kSmallStep && result.iterations > kMovingReference;

    // The levels follow once the path fits.
    if (signs.rows() != rows.e.size()) signs = probes(rows.e.size());
    const LevelSlope slope = level_slope(rows, solver, weights, signs, levels);
    Eigen::MatrixXd information = slope.information;
    Eigen::VectorXd gradient = slope.gradient - log_levels / (kLevelPrior * kLevelPrior);
    information.diagonal().array() += 1.0 / (kLevelPrior * kLevelPrior);
    const Eigen::LDLT<Eigen::MatrixXd> level_solver(information);
    const Eigen::VectorXd level_sigma =
        level_solver.solve(Eigen::MatrixXd::Identity(levels, levels)).diagonal().cwiseMax(1e-12).cwiseSqrt();
    if (result.iterations > 3) {
      Eigen::VectorXd level_step =
          level_solver.solve(gradient).cwiseMax(-kLongestLevelStep).cwiseMin(kLongestLevelStep);
      // Near zero a level's logarithm jumps back and forth about its place.
      for (Eigen::Index k = 0; k < levels; ++k) damping(k) *= level_step(k) * last_level_step(k) < 0.0 ? 0.5 : 1.0;
      level_step = level_step.cwiseProduct(damping);
      last_level_step = level_step;
      log_levels += level_step;
      is_settled = is_settled && ((level_step.array().abs() < kSmallLevelStep) ||
                                  (level_step.array().abs() < kSmallStep * level_sigma.array()))
                                     .all();
    } else {
      is_settled = false;
    }

    for (Eigen::Index k = 0; k < columns; ++k) {
      const auto i = static_cast<Eigen::Index>(equations.columns()[static_cast<std::size_t>(k)]);
      result.change(i) = x(first + k);
      result.sigma(i) = sigma(k);
      result.information(i) = 1.0 - std::min(1.0, sigma(k) * sigma(k) / (prior(k) * prior(k)));
    }
    for (Eigen::Index k = 0; k < levels; ++k) {
      const auto i = static_cast<Eigen::Index>(equations.levels()[static_cast<std::size_t>(k)]);
      if (i < 0) continue;
      result.change(i) = log_levels(k);
      result.sigma(i) = level_sigma(k);
      result.information(i) = 1.0 - std::min(1.0, level_sigma(k) * level_sigma(k) / (kLevelPrior * kLevelPrior));
    }
    result.converged = is_settled;
    progress(result);
  }
  return result;
}

}  // namespace waymark::calibration
