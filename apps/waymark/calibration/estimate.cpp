// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/estimate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "apps/waymark/jobs/jobs.hpp"

namespace waymark::calibration {

namespace {

constexpr int kMostIterations = 20;
constexpr int kMostHalvings = 4;
constexpr double kSmallStep = 0.1;   // of σ: converged
constexpr std::size_t kBlocks = 20;  // of time, for the scatter of the scores

/// The standardised residuals of one innovation: w = L⁻¹ν and (w wᵀ − I) / −√2, the upper triangle with the
/// off-diagonal elements times √2, so that the scalar product is that of the matrices. Their squares' gradient is that
/// of −2 log N.
Eigen::VectorXd residuals(const Eigen::VectorXd& w) {
  const Eigen::Index rows = w.size();
  Eigen::VectorXd r(rows + rows * (rows + 1) / 2);
  r.head(rows) = w;
  Eigen::Index k = rows;
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = i; j < rows; ++j) {
      const double element = w(i) * w(j) - (i == j ? 1.0 : 0.0);
      r(k++) = -element * (i == j ? 1.0 : std::numbers::sqrt2) / std::numbers::sqrt2;
    }
  }
  return r;
}

/// Their derivative for changes dν and dS (both divided by the step), with the base's L.
Eigen::VectorXd derivatives(const Eigen::LLT<Eigen::MatrixXd>& L, const Eigen::VectorXd& d_nu,
                            const Eigen::MatrixXd& d_S) {
  const Eigen::Index rows = d_nu.size();
  Eigen::VectorXd J(rows + rows * (rows + 1) / 2);
  J.head(rows) = L.matrixL().solve(d_nu);
  const Eigen::MatrixXd half = L.matrixL().solve(d_S);
  const Eigen::MatrixXd B = L.matrixL().solve(half.transpose());
  Eigen::Index k = rows;
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = i; j < rows; ++j)
      J(k++) = B(i, j) * (i == j ? 1.0 : std::numbers::sqrt2) / std::numbers::sqrt2;
  }
  return J;
}

/// Huber's weight of an innovation with this NIS: 1 up to the 99 % quantile, then falling.
double weight_of(double nis, Eigen::Index rows) {
  const double bound = gaussian::chi_squared_quantile(0.99, static_cast<int>(rows));
  return nis <= bound ? 1.0 : std::sqrt(bound / nis);
}

/// −log likelihood of a run (without constants), each innovation's part bounded as Huber's, and the mean NIS per row.
struct Fit {
  double cost = 0.0;
  double nis = 0.0;
};

Fit fit_of(const Run& run) {
  Fit fit;
  double rows = 0.0;
  for (const Innovation& one : run.innovations) {
    const Eigen::LLT<Eigen::MatrixXd> L(Eigen::MatrixXd(one.S));
    if (L.info() != Eigen::Success) continue;
    const Eigen::VectorXd w = L.matrixL().solve(Eigen::VectorXd(one.nu));
    const double nis = w.squaredNorm();
    const double bound = gaussian::chi_squared_quantile(0.99, static_cast<int>(w.size()));
    const double huber = nis <= bound ? nis : 2.0 * std::sqrt(nis * bound) - bound;
    fit.cost += 0.5 * huber + Eigen::MatrixXd(L.matrixL()).diagonal().array().log().sum();
    fit.nis += std::min(nis, 100.0 * static_cast<double>(w.size()));
    rows += static_cast<double>(w.size());
  }
  fit.nis /= std::max(rows, 1.0);
  return fit;
}

/// The innovation of the same update in another run, or null.
class Matching {
 public:
  explicit Matching(const Run& run) : innovations_(run.innovations) {}
  const Innovation* next(const Innovation& wanted) {
    while (at_ < innovations_.size() && innovations_[at_].id() < wanted.id()) ++at_;
    const bool same = at_ < innovations_.size() && innovations_[at_].id() == wanted.id() &&
                      innovations_[at_].nu.size() == wanted.nu.size();
    return same ? &innovations_[at_] : nullptr;
  }

 private:
  const std::vector<Innovation>& innovations_;
  std::size_t at_ = 0;
};

/// Gradient and information of the log likelihood at one point.
struct Slope {
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;  // Fisher's
  Eigen::MatrixXd scatter;      // of the scores, over blocks of time
};

Slope slope_at(const Run& base, const std::vector<Run>& ahead, const std::vector<Run>& behind,
               const std::vector<Parameter>& parameters) {
  const auto count = static_cast<Eigen::Index>(parameters.size());
  Slope slope{Eigen::VectorXd::Zero(count), Eigen::MatrixXd::Zero(count, count), Eigen::MatrixXd::Zero(count, count)};
  std::vector<Matching> plus(ahead.begin(), ahead.end());
  std::vector<Matching> minus(behind.begin(), behind.end());
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(kBlocks));
  for (std::size_t n = 0; n < base.innovations.size(); ++n) {
    const Innovation& one = base.innovations[n];
    const Eigen::LLT<Eigen::MatrixXd> L(Eigen::MatrixXd(one.S));
    if (L.info() != Eigen::Success) continue;
    const Eigen::VectorXd w = L.matrixL().solve(Eigen::VectorXd(one.nu));
    const double weight = weight_of(w.squaredNorm(), w.size());
    const Eigen::VectorXd r = residuals(weight * w);
    Eigen::MatrixXd J(r.size(), count);
    bool complete = true;
    for (std::size_t i = 0; i < parameters.size() && complete; ++i) {
      const Innovation* up = plus[i].next(one);
      const Innovation* down = minus[i].next(one);
      complete = up != nullptr && down != nullptr;
      if (!complete) break;
      const double width = 2.0 * parameters[i].step;
      J.col(static_cast<Eigen::Index>(i)) = derivatives(L, (up->nu - down->nu) / width, (up->S - down->S) / width);
    }
    if (!complete) continue;
    const Eigen::VectorXd score = J.transpose() * r;
    slope.gradient += score;
    slope.information += weight * J.transpose() * J;
    scores.col(static_cast<Eigen::Index>(n * kBlocks / base.innovations.size())) += score;
  }
  const Eigen::VectorXd mean = scores.rowwise().mean();
  for (Eigen::Index b = 0; b < scores.cols(); ++b)
    slope.scatter += (scores.col(b) - mean) * (scores.col(b) - mean).transpose();
  slope.scatter *= static_cast<double>(kBlocks) / static_cast<double>(kBlocks - 1);
  return slope;
}

}  // namespace

Estimate estimate(const std::vector<Parameter>& parameters, const Rerun& rerun, int jobs,
                  const std::function<void(const Estimate&)>& progress) {
  const auto count = static_cast<Eigen::Index>(parameters.size());
  Eigen::VectorXd prior(count);
  for (Eigen::Index i = 0; i < count; ++i) prior(i) = parameters[static_cast<std::size_t>(i)].prior_sigma;
  const Eigen::VectorXd prior_information = prior.array().square().inverse();
  const auto penalty = [&](const Eigen::VectorXd& change) {
    return 0.5 * (change.array() / prior.array()).square().sum();
  };

  Estimate result;
  result.change = Eigen::VectorXd::Zero(count);
  result.sigma = prior;
  result.information = Eigen::VectorXd::Zero(count);
  Run base = rerun(result.change);
  Fit fit = fit_of(base);
  result.nis_before = result.nis_after = fit.nis;

  while (!result.converged && result.iterations < kMostIterations) {
    ++result.iterations;
    std::vector<Run> ahead(parameters.size());
    std::vector<Run> behind(parameters.size());
    const auto one_run = [&](std::size_t task) {
      const std::size_t i = task / 2;
      Eigen::VectorXd change = result.change;
      change(static_cast<Eigen::Index>(i)) += (task % 2 == 0 ? 1.0 : -1.0) * parameters[i].step;
      (task % 2 == 0 ? ahead : behind)[i] = rerun(change);
    };
    jobs::run_all(2 * parameters.size(), jobs, one_run, [](std::size_t) {});
    const Slope slope = slope_at(base, ahead, behind, parameters);

    Eigen::MatrixXd information = slope.information;
    information.diagonal() += prior_information;
    const Eigen::LDLT<Eigen::MatrixXd> solver(information);
    const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(count, count));
    const Eigen::MatrixXd sandwich =
        covariance * (slope.scatter + Eigen::MatrixXd(prior_information.asDiagonal())) * covariance;
    result.sigma = covariance.diagonal().cwiseMax(sandwich.diagonal()).cwiseSqrt();
    result.information = 1.0 - (result.sigma.array() / prior.array()).square().min(1.0);

    const Eigen::VectorXd gradient = slope.gradient + prior_information.cwiseProduct(result.change);
    Eigen::VectorXd step = -solver.solve(gradient);
    // No parameter moves by more than half of its prior's σ at once: the derivatives hold near the point only.
    const double longest = (step.array().abs() / prior.array()).maxCoeff();
    if (longest > 0.5) step *= 0.5 / longest;
    bool improved = false;
    for (int halving = 0; halving <= kMostHalvings && !improved; ++halving, step *= 0.5) {
      const Eigen::VectorXd tried = result.change + step;
      Run run = rerun(tried);
      const Fit tried_fit = fit_of(run);
      if (tried_fit.cost + penalty(tried) >= fit.cost + penalty(result.change)) continue;
      improved = true;
      result.change = tried;
      base = std::move(run);
      fit = tried_fit;
      result.nis_after = fit.nis;
      result.converged = (step.array().abs() < kSmallStep * result.sigma.array()).all();
      break;
    }
    // A step that small cannot improve anything that counts.
    if (!improved) result.converged = (step.array().abs() < kSmallStep * result.sigma.array()).all();
    progress(result);
    if (!improved) break;
  }
  return result;
}

}  // namespace waymark::calibration
