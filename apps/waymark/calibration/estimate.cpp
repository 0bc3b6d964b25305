// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/estimate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/waymark/jobs/jobs.hpp"

namespace waymark::calibration {

namespace {

constexpr int kMostIterations = 20;
constexpr int kMostHalvings = 2;
constexpr double kFarther = 1.2;         // a step that makes the way to the solution longer by this factor went too far
constexpr double kSmallStep = 0.1;       // of σ: converged
constexpr double kSmallNoiseStep = 0.5;  // of σ, of a level of noise: near zero its logarithm never settles
constexpr std::size_t kBlocks = 20;      // of time, for the scatter of the scores

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

/// Mean NIS per row.
double mean_nis(const Run& run) {
  double sum = 0.0;
  double rows = 0.0;
  for (const Innovation& one : run.innovations) {
    const Eigen::LLT<Eigen::MatrixXd> L(Eigen::MatrixXd(one.S));
    if (L.info() != Eigen::Success) continue;
    const double nis = L.matrixL().solve(Eigen::VectorXd(one.nu)).squaredNorm();
    const double count = static_cast<double>(one.nu.size());
    sum += std::min(nis, 100.0 * count);
    rows += count;
  }
  return sum / std::max(rows, 1.0);
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

/// Gradient and information of −log likelihood at one point. That S depends on the geometry counts for nothing: where
/// the shape of the noise model is wrong, the geometry would otherwise change to mend S.
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
      Eigen::MatrixXd d_S = (up->S - down->S) / width;
      if (parameters[i].kind != Parameter::Kind::noise) d_S.setZero();
      J.col(static_cast<Eigen::Index>(i)) = derivatives(L, (up->nu - down->nu) / width, d_S);
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
  Eigen::VectorXd small(count);
  Eigen::VectorXd longest(count);  // step: the derivatives hold near the point only
  for (Eigen::Index i = 0; i < count; ++i) {
    const Parameter& parameter = parameters[static_cast<std::size_t>(i)];
    prior(i) = parameter.prior_sigma;
    const bool is_noise = parameter.kind == Parameter::Kind::noise;
    longest(i) = 0.5 * prior(i);
    small(i) = is_noise ? kSmallNoiseStep : kSmallStep;
  }
  const Eigen::VectorXd prior_information = prior.array().square().inverse();

  Estimate result;
  result.change = Eigen::VectorXd::Zero(count);
  result.sigma = prior;
  result.information = Eigen::VectorXd::Zero(count);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(count);  // that led to `at`
  Eigen::VectorXd at = result.change;
  double distance = std::numeric_limits<double>::infinity();
  int halvings = 0;
  while (!result.converged && result.iterations < kMostIterations) {
    ++result.iterations;
    Run base;
    std::vector<Run> ahead(parameters.size());
    std::vector<Run> behind(parameters.size());
    const auto one_run = [&](std::size_t task) {
      if (task == 0) {
        base = rerun(at);
        return;
      }
      const std::size_t i = (task - 1) / 2;
      Eigen::VectorXd change = at;
      change(static_cast<Eigen::Index>(i)) += (task % 2 == 0 ? 1.0 : -1.0) * parameters[i].step;
      (task % 2 == 0 ? ahead : behind)[i] = rerun(change);
    };
    jobs::run_all(2 * parameters.size() + 1, jobs, one_run, [](std::size_t) {});
    const Slope slope = slope_at(base, ahead, behind, parameters);

    Eigen::MatrixXd information = slope.information;
    information.diagonal() += prior_information;
    const Eigen::LDLT<Eigen::MatrixXd> solver(information);
    const Eigen::VectorXd gradient = slope.gradient + prior_information.cwiseProduct(at);
    const Eigen::VectorXd to_solution = -solver.solve(gradient);
    const double left = std::sqrt(std::max(0.0, -gradient.dot(to_solution)));  // in σ
    if (left > kFarther * distance && halvings < kMostHalvings) {
      ++halvings;
      step *= 0.5;
      at = result.change + step;
      continue;
    }
    halvings = 0;
    distance = left;
    result.change = at;
    result.nis_after = mean_nis(base);
    if (result.iterations == 1) result.nis_before = result.nis_after;
    const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(count, count));
    const Eigen::MatrixXd sandwich =
        covariance * (slope.scatter + Eigen::MatrixXd(prior_information.asDiagonal())) * covariance;
    result.sigma = covariance.diagonal().cwiseMax(sandwich.diagonal()).cwiseSqrt();
    result.information = 1.0 - (result.sigma.array() / prior.array()).square().min(1.0);
    result.converged = (to_solution.array().abs() < small.array() * result.sigma.array()).all();
    step = to_solution / std::max(1.0, (to_solution.array().abs() / longest.array()).maxCoeff());
    at = result.change + step;
    progress(result);
  }
  return result;
}

}  // namespace waymark::calibration
