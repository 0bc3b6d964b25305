// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/consistency.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "apps/waymark/evaluation/table.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::evaluation {

namespace {

constexpr int kPlanarColumns = 7;
constexpr int kSpatialColumns = 15;

/// The further columns are those of z, the rotation about x and that about y: each with those before it, and itself.
SpatialMatrix spatial(const Table& table, std::size_t row, const Eigen::Matrix3d& planar) {
  constexpr std::array<int, 6> kOrder{0, 1, 5, 2, 3, 4};
  SpatialMatrix P = SpatialMatrix::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      P(kOrder[i], kOrder[j]) = planar(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
  int column = kPlanarColumns;
  for (std::size_t i = 3; i < kOrder.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j)
      P(kOrder[i], kOrder[j]) = P(kOrder[j], kOrder[i]) = table.number(row, column++, "spatial covariance");
  }
  return P;
}

constexpr double kCertain = 1e-4;  // [m]

bool is_certain(const PoseCovariance& covariance) {
  return covariance.P(0, 0) + covariance.P(1, 1) < kCertain * kCertain;
}

/// eᵀ P⁻¹ e; nothing if P is not positive definite.
std::optional<double> squared_in_units_of(const Eigen::MatrixXd& P, const Eigen::VectorXd& error) {
  const Eigen::LDLT<Eigen::MatrixXd> factor(P);
  if (!factor.isPositive() || factor.vectorD().minCoeff() <= 0.0) return std::nullopt;
  return error.dot(factor.solve(error));
}

/// `nees_of(covariance, estimated, truth)`: at each time at which both are known and the position is not held for
/// certain.
template <class NeesOf>
Consistency score(const std::vector<PoseCovariance>& covariances, const Trajectory& estimate,
                  const Trajectory& reference, const ConsistencyOptions& options, int dimensions,
                  const NeesOf& nees_of) {
  std::vector<double> nees;
  for (const PoseCovariance& covariance : covariances) {
    Pose estimated;
    Pose truth;
    if (pose_at(estimate, covariance.stamp, options.max_time_gap_s, estimated) != Lookup::found ||
        pose_at(reference, covariance.stamp, options.max_time_gap_s, truth) != Lookup::found || is_certain(covariance))
      continue;
    if (const auto one = nees_of(covariance, options.T_reference_estimate * estimated, truth)) nees.push_back(*one);
  }
  if (nees.empty()) throw Error("consistency: no time at which covariance, estimate and reference are known");
  return summarize_nees(std::move(nees), dimensions);
}

}  // namespace

Consistency summarize_nees(std::vector<double> nees, int dimensions) {
  Consistency out;
  const auto count = static_cast<double>(nees.size());
  const double bound = gaussian::chi_squared_quantile(0.95, dimensions);
  const auto share = [&](auto holds) { return static_cast<double>(std::ranges::count_if(nees, holds)) / count; };
  out.dimensions = dimensions;
  out.scored = nees.size();
  out.share_within_95 = share([&](double n) { return n <= bound; });
  out.low_95 = gaussian::chi_squared_quantile(0.025, dimensions);
  out.high_95 = gaussian::chi_squared_quantile(0.975, dimensions);
  out.share_below = share([&](double n) { return n < out.low_95; });
  out.share_above = share([&](double n) { return n > out.high_95; });
  const int dof = dimensions * static_cast<int>(nees.size());
  out.mean_low_95 = gaussian::chi_squared_quantile(0.025, dof) / count;
  out.mean_high_95 = gaussian::chi_squared_quantile(0.975, dof) / count;
  for (std::size_t q = 0; q < 4; ++q) {
    const std::size_t begin = q * nees.size() / 4;
    const std::size_t end = (q + 1) * nees.size() / 4;
    const double sum = std::accumulate(nees.begin() + static_cast<std::ptrdiff_t>(begin),
                                       nees.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
    out.mean_by_quarter[q] = end > begin ? sum / static_cast<double>(end - begin) : 0.0;
  }
  out.nees = statistics(std::move(nees));
  return out;
}

std::vector<PoseCovariance> read_covariances(const std::filesystem::path& file) {
  Table table(file);
  if (table.starts_with_names({"t_s", "xx", "xy", "xyaw", "yy", "yyaw", "yawyaw"})) table.drop_first_row();
  std::vector<PoseCovariance> out;
  out.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto number = [&](int column, const char* name) { return table.number(row, column, name); };
    PoseCovariance one;
    one.stamp = table.time(row, 0);
    const double xy = number(2, "xy");
    const double xyaw = number(3, "xyaw");
    const double yyaw = number(5, "yyaw");
    one.P << number(1, "xx"), xy, xyaw, xy, number(4, "yy"), yyaw, xyaw, yyaw, number(6, "yawyaw");
    if (table.width() >= kPlanarColumns + kSpatialColumns) one.P_spatial = spatial(table, row, one.P);
    out.push_back(one);
  }
  return out;
}

Consistency score_consistency(const std::vector<PoseCovariance>& covariances, const Trajectory& estimate,
                              const Trajectory& reference, const ConsistencyOptions& options) {
  if (estimate.orientation == Orientation::none) throw Error("consistency: " + estimate.name + " has no orientation");
  const int dimensions = reference.orientation == Orientation::none ? 2 : 3;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = options.T_reference_estimate.q.toRotationMatrix().topLeftCorner<2, 2>();
  std::array<std::vector<double>, 3> sigmas;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  const auto nees_of = [&](const PoseCovariance& covariance, const Pose& estimated, const Pose& truth) {
    const Eigen::Vector3d arm = dimensions == 2 ? (estimated.q * options.lever_arm_m).eval() : Eigen::Vector3d::Zero();
    const Eigen::Vector3d p = estimated.p + arm;
    const Eigen::Vector3d error(p.x() - truth.p.x(), p.y() - truth.p.y(), so3::wrap(estimated.yaw() - truth.yaw()));
    Eigen::Matrix3d J = turn;
    J.col(2) += Eigen::Vector3d(-arm.y(), arm.x(), 0.0);
    Eigen::Matrix3d P = J * covariance.P * J.transpose();
    P.topLeftCorner<2, 2>().diagonal().array() += options.reference_sigma_m * options.reference_sigma_m;
    squares += error.cwiseAbs2();
    for (std::size_t i = 0; i < sigmas.size(); ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      sigmas[i].push_back(std::sqrt(std::max(0.0, P(axis, axis))));
    }
    return squared_in_units_of(P.topLeftCorner(dimensions, dimensions), error.head(dimensions));
  };
  Consistency out = score(covariances, estimate, reference, options, dimensions, nees_of);
  for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i) {
    const double rms = std::sqrt(squares[static_cast<Eigen::Index>(i)] / static_cast<double>(sigmas[i].size()));
    if (rms > 0.0) out.sigma_by_rms[i] = statistics(std::move(sigmas[i])).median / rms;
  }
  return out;
}

std::optional<Consistency> score_spatial_consistency(const std::vector<PoseCovariance>& covariances,
                                                     const Trajectory& estimate, const Trajectory& reference,
                                                     const ConsistencyOptions& options) {
  const bool has_all =
      std::ranges::all_of(covariances, [](const PoseCovariance& one) { return one.P_spatial.has_value(); });
  if (!has_all || estimate.orientation != Orientation::full || reference.orientation != Orientation::full)
    return std::nullopt;
  SpatialMatrix turn = SpatialMatrix::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = options.T_reference_estimate.q.toRotationMatrix();
  const auto nees_of = [&](const PoseCovariance& covariance, const Pose& estimated, const Pose& truth) {
    SpatialVector error;
    error << estimated.p - truth.p, so3::log(estimated.q * truth.q.conjugate());
    return squared_in_units_of(turn * *covariance.P_spatial * turn.transpose(), error);
  };
  return score(covariances, estimate, reference, options, 6, nees_of);
}

}  // namespace waymark::evaluation
