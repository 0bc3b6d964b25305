// SPDX-License-Identifier: Apache-2.0
#include "lever_fit.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>

#include "dead_reckoning.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

using Complex = std::complex<double>;

constexpr double kStep = 1.6;     // [s] from fix to fix of one row
constexpr double kBlock = 20.0;   // [s] in which the heading's drift does not matter
constexpr long kLeastRows = 8;    // of a block
constexpr double kMostLag = 2.0;  // [s]
constexpr double kLagStep = 0.1;
constexpr int kLeastBlocks = 4;
constexpr double kMostInflation = 10.0;
constexpr double kLeastLeverSigma = 0.02;  // [m], of a block
constexpr double kLikelier = 0.1;  // by which the log of the squared residuals must be less, as a mean over the blocks

/// z = c w + q u as two rows of real numbers.
void add_row(Rows& rows, Complex z, Complex w, Complex u) {
  rows.A.row(rows.count) << w.real(), -w.imag(), u.real(), -u.imag();
  rows.y(rows.count++) = z.real();
  rows.A.row(rows.count) << w.imag(), w.real(), u.imag(), u.real();
  rows.y(rows.count++) = z.imag();
}

/// The steps from fix to fix of one block, for a lag.
Rows rows_of(const std::vector<Fix>& fixes, std::size_t begin, std::size_t end, const DeadReckoning& path, double lag) {
  Rows rows(2 * static_cast<Eigen::Index>(end - begin), 4);
  std::size_t from = begin;
  for (std::size_t k = begin + 1; k < end; ++k) {
    if (fixes[k].t - fixes[from].t < kStep) continue;
    const Eigen::Vector2d d = fixes[k].p - fixes[from].p;
    const auto step = path.step(fixes[from].t - lag, fixes[k].t - lag);
    const bool is_near = fixes[k].t - fixes[from].t < 3.0 * kStep;
    from = k;
    if (!step || !is_near) continue;
    add_row(rows, {d.x(), d.y()}, step->second.p - step->first.p,
            std::polar(1.0, step->second.yaw) - std::polar(1.0, step->first.yaw));
  }
  return rows;
}

/// Lever arm and remaining error of one block.
struct BlockFit {
  Eigen::Vector2d lever;
  double sigma = 0.0;  ///< of the lever arm, of both axes [m]
  double residual = 0.0;
};

/// The same with a known lever arm, which leaves the heading and the scale of the block.
std::optional<double> residual_with(const Rows& rows, const Eigen::Vector2d& lever) {
  if (rows.count < 2 * kLeastRows) return std::nullopt;
  Rows known(rows.count, 2);
  for (Eigen::Index k = 0; k + 1 < rows.count; k += 2) {
    const Complex w = Complex(rows.A(k, 0), rows.A(k + 1, 0)) +
                      Complex(rows.A(k, 2), rows.A(k + 1, 2)) * Complex(lever.x(), lever.y());
    known.A.row(known.count) << w.real(), -w.imag();
    known.y(known.count++) = rows.y(k);
    known.A.row(known.count) << w.imag(), w.real();
    known.y(known.count++) = rows.y(k + 1);
  }
  const Fit fit = fit_rows(known);
  if (!fit.valid) return std::nullopt;
  // Clipped: one wild fix must not decide.
  const Eigen::VectorXd r = known.y.head(known.count) - known.A.topRows(known.count) * fit.x;
  const double clip = 9.0 * fit.residual * fit.residual;
  return r.array().square().min(clip).mean();
}

/// By how much the free heading and scale of a block widen σ² of a lever arm: on one circle they are the same.
double inflation(const Rows& rows) {
  const auto A = rows.A.topRows(rows.count);
  const Eigen::Matrix4d H = A.transpose() * A;
  const double alone = H.trace() > 0.0 ? H(2, 2) : 0.0;
  const Eigen::Matrix2d left = H.bottomRightCorner<2, 2>() - H.bottomLeftCorner<2, 2>() *
                                                                 H.topLeftCorner<2, 2>().inverse() *
                                                                 H.topRightCorner<2, 2>();
  const double rest = 0.5 * left.trace();
  return rest > 0.0 ? alone / rest : std::numeric_limits<double>::infinity();
}

std::optional<BlockFit> fit_block(const Rows& rows) {
  if (rows.count < 2 * kLeastRows || inflation(rows) > kMostInflation) return std::nullopt;
  const Fit fit = fit_rows(rows);
  if (!fit.valid) return std::nullopt;
  const Complex c(fit.x(0), fit.x(1));
  if (std::abs(c) < 0.1) return std::nullopt;
  const Complex lever = Complex(fit.x(2), fit.x(3)) * std::abs(c) / c;
  const Eigen::VectorXd r = rows.y.head(rows.count) - rows.A.topRows(rows.count) * fit.x;
  const double sigma = std::max(std::hypot(fit.sigma(2), fit.sigma(3)), 1e-3);
  return BlockFit{{lever.real(), lever.imag()}, sigma, std::sqrt(r.squaredNorm() / static_cast<double>(rows.count))};
}

/// A mean over blocks, of which those without a turn know next to nothing of a lever arm.
struct WeightedMean {
  double value = 0.0;
  double sigma = 0.0;
};

/// Weights of Huber's kind for blocks that lie farther off than their σ lets expect; σ by the scatter of the blocks
/// (White, 1982), but not below `least` for a block.
WeightedMean mean_of(const std::vector<double>& values, const std::vector<double>& sigmas, double least) {
  constexpr double kHuber = 1.5;
  WeightedMean mean;
  const std::size_t n = values.size();
  std::vector<double> weights(n);
  for (std::size_t k = 0; k < n; ++k) weights[k] = 1.0 / (sigmas[k] * sigmas[k] + least * least);
  for (int iteration = 0; iteration < 10; ++iteration) {
    double sum = 0.0;
    double weight = 0.0;
    double squares = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double own = 1.0 / (sigmas[k] * sigmas[k] + least * least);
      const double off = iteration == 0 ? 0.0 : std::abs(values[k] - mean.value) * std::sqrt(own);
      weights[k] = own * (off > kHuber ? kHuber / off : 1.0);
      sum += weights[k] * values[k];
      weight += weights[k];
      squares += weights[k] * weights[k];
    }
    mean.value = sum / weight;
    const double effective = weight * weight / squares;  // blocks that count
    double scatter = 0.0;
    for (std::size_t k = 0; k < n; ++k) scatter += std::pow(weights[k] * (values[k] - mean.value), 2);
    const double few = effective > 1.5 ? effective / (effective - 1.0) : 3.0;
    mean.sigma = std::max(std::sqrt(few * scatter) / weight, 1.25 * std::sqrt(squares) / weight * least);
    mean.sigma = std::max(mean.sigma, 1.0 / std::sqrt(weight));
  }
  return mean;
}

constexpr int kSteps = static_cast<int>(kMostLag / kLagStep);

/// Median of the lengths of single motions by those of the way, along the direction in which the scanner moves.
void find_median(const Rows& rows, MountingFit& mounting) {
  constexpr double kLeastWay = 0.05;  // [m]
  const Complex lever = std::polar(1.0, mounting.angle) * Complex(mounting.lever.x(), mounting.lever.y());
  std::vector<double> scales;
  scales.reserve(static_cast<std::size_t>(rows.count / 2));
  for (Eigen::Index k = 0; k + 1 < rows.count; k += 2) {
    const Complex w(rows.A(k, 0), rows.A(k + 1, 0));
    if (std::abs(w) < kLeastWay) continue;
    const Complex z = Complex(rows.y(k), rows.y(k + 1)) - lever * Complex(rows.A(k, 2), rows.A(k + 1, 2));
    scales.push_back((z / w * std::polar(1.0, -mounting.angle)).real());
  }
  if (scales.empty()) return;
  std::ranges::sort(scales);
  constexpr double kQuartilesToSigma = 0.93;  // of a median: 1.253 / 1.349
  const double quartiles = scales[scales.size() - 1 - scales.size() / 4] - scales[scales.size() / 4];
  mounting.median_scale = scales[scales.size() / 2];
  mounting.median_sigma = kQuartilesToSigma * quartiles / std::sqrt(static_cast<double>(scales.size()));
}

}  // namespace

MountingFit fit_mounting(const std::vector<ScanStep>& steps, const Track& way, double late) {
  MountingFit mounting;
  Rows rows(2 * static_cast<Eigen::Index>(steps.size()), 4);
  for (const ScanStep& step : steps) {
    const auto driven = way.change(step.from - late, step.to - late);
    if (!driven || !step.is_shift_known) continue;
    add_row(rows, {step.shift.x(), step.shift.y()}, *driven * std::polar(1.0, 0.5 * step.yaw),
            std::polar(1.0, step.yaw) - 1.0);
  }
  if (rows.count < 40) return mounting;
  Eigen::VectorXd first = Eigen::VectorXd::Zero(4);
  // Direction and scale of the median motion: half of the matches may be wrong.
  std::vector<double> along;
  std::vector<double> across;
  for (Eigen::Index k = 0; k + 1 < rows.count; k += 2) {
    const Complex w(rows.A(k, 0), rows.A(k + 1, 0));
    if (std::abs(w) < 1e-3) continue;
    const Complex c = Complex(rows.y(k), rows.y(k + 1)) / w;
    along.push_back(c.real());
    across.push_back(c.imag());
  }
  if (along.size() < 20) return mounting;
  first(0) = median(along);
  first(1) = median(across);
  const Fit fit = fit_rows(rows, first);
  if (!fit.valid) return mounting;
  const Complex c(fit.x(0), fit.x(1));
  mounting.scale = std::abs(c);
  mounting.angle = std::arg(c);
  const double sigma = std::hypot(fit.sigma(0), fit.sigma(1));
  if (!(mounting.scale > 5.0 * sigma)) return mounting;
  mounting.scale_sigma = sigma;
  mounting.angle_sigma = sigma / mounting.scale;
  const Complex lever = Complex(fit.x(2), fit.x(3)) / c * mounting.scale;
  mounting.lever = {lever.real(), lever.imag()};
  mounting.lever_sigma = {fit.sigma(2), fit.sigma(3)};
  mounting.kept = fit.kept;
  mounting.is_known = true;
  find_median(rows, mounting);
  return mounting;
}

AntennaFit fit_antenna(const std::vector<Fix>& fixes, const Eigen::Vector2d& lever, const Track& yaw, const Way& way,
                       double per_way, double per_s, double late) {
  AntennaFit antenna;
  if (fixes.size() < 4 * static_cast<std::size_t>(kLeastRows)) return antenna;
  const DeadReckoning path(yaw, way, per_way, per_s, late);
  std::vector<std::pair<std::size_t, std::size_t>> blocks;
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= fixes.size(); ++k) {
    if (k < fixes.size() && fixes[k].t - fixes[begin].t < kBlock) continue;
    blocks.emplace_back(begin, k);
    begin = k;
  }
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> sigmas;
  std::vector<double> residuals;
  std::vector<std::vector<double>> costs;  // of each block, at each lag
  for (const auto& [from, to] : blocks) {
    if (const auto fit = fit_block(rows_of(fixes, from, to, path, 0.0))) {
      x.push_back(fit->lever.x());
      y.push_back(fit->lever.y());
      sigmas.push_back(fit->sigma);
      residuals.push_back(fit->residual);
    }
    std::vector<double> of_block;
    bool is_complete = true;
    for (int i = -kSteps; i <= kSteps && is_complete; ++i) {
      const auto residual = residual_with(rows_of(fixes, from, to, path, i * kLagStep), lever);
      is_complete = residual.has_value();
      // Each block has a noise of its own: the likelihood at its maximum over that.
      if (residual) of_block.push_back(std::log(std::max(*residual, 1e-12)));
    }
    if (is_complete) costs.push_back(std::move(of_block));
  }
  if (static_cast<int>(x.size()) >= kLeastBlocks) {
    const WeightedMean ahead = mean_of(x, sigmas, kLeastLeverSigma);
    const WeightedMean aside = mean_of(y, sigmas, kLeastLeverSigma);
    antenna.lever = {ahead.value, aside.value};
    antenna.lever_sigma = {ahead.sigma, aside.sigma};
    antenna.residual = median(residuals);
    antenna.is_known = true;
  }
  antenna.lag = lag_of(costs, kLagStep);
  if (!antenna.is_known || !antenna.lag.is_known) return antenna;
  double of_lever = 0.0;
  double of_lag = 0.0;
  double count = 0.0;
  for (const auto& [from, to] : blocks) {
    const Rows rows = rows_of(fixes, from, to, path, 0.0);
    const auto as_given = residual_with(rows, lever);
    const auto with_lever = residual_with(rows, antenna.lever);
    const auto with_lag = residual_with(rows_of(fixes, from, to, path, antenna.lag.value), lever);
    if (!as_given || !with_lever || !with_lag) continue;
    of_lever += std::log(std::max(*as_given, 1e-12) / std::max(*with_lever, 1e-12));
    of_lag += std::log(std::max(*as_given, 1e-12) / std::max(*with_lag, 1e-12));
    count += 1.0;
  }
  antenna.is_lever_likelier = of_lever - of_lag > kLikelier * count;
  antenna.is_lag_likelier = of_lag > kLikelier * count;
  return antenna;
}

}  // namespace waymark::host::diagnosis
