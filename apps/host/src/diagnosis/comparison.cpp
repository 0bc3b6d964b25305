// SPDX-License-Identifier: Apache-2.0
#include "comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>

#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kClearTurn = 0.25;  // [rad], more than the noise of a compass
constexpr Eigen::Index kFewTurns = 5;
constexpr double kStill = 0.2;          // [m/s], slower is no motion for an unsigned way
constexpr double kMostSigmas = 1000.0;  // more says nothing
constexpr double kSigmas = 3.0;
constexpr double kRelative = 0.15;           // errors of a turn or a way that grow with it
constexpr double kVague = 0.35;              // a ratio whose bounds are farther apart, as a share, is not known
constexpr double kDefinite = 0.125;          // σ of a ratio that differs, as a share
constexpr double kDefiniteSign = 1.0 / 6.0;  // likewise of one that is wrong by little but its sign
constexpr double kUnrelated = 0.1;           // squared correlation of two that have nothing to do with each other
constexpr long kLeastUnrelated = 40;         // spans that show it
constexpr double kMostShare = 0.3;           // of the changes of one that the other may have
constexpr double kLargeTurn = 0.05;          // [rad]
constexpr double kVaguePerWay = 0.03;        // [rad/m]
constexpr double kShiftStep = 0.1;           // [s]
constexpr double kWild = 1.0;                // [rad]
constexpr double kBetter = 0.7;              // of what two do not have in common, that a shift must leave at most
constexpr double kMostLag = 2.0;             // [s]
constexpr double kLagStep = 0.05;
constexpr std::size_t kParts = 8;
constexpr std::size_t kLeastParts = 4;
constexpr double kClear = 0.08;   // by which the worst lag must cost more than the best, as a mean over the parts
constexpr double kFreedom = 4.0;  // degrees of, of Student's t
constexpr double kLeastSpansOfPart = 10;

/// Slope that half of the total weight lies above: robust against whatever half of the rows is.
double first_slope(const Rows& rows) {
  std::vector<std::pair<double, double>> slopes;
  double sum = 0.0;
  for (Eigen::Index k = 0; k < rows.count; ++k) {
    const double x = rows.A(k, 0);
    if (x == 0.0) continue;
    slopes.emplace_back(rows.y(k) / x, std::abs(x));
    sum += std::abs(x);
  }
  std::ranges::sort(slopes);
  double before = 0.0;
  for (const auto& [slope, weight] : slopes) {
    before += weight;
    if (2.0 * before >= sum) return slope;
  }
  return 1.0;
}

Fit fit_ratio(const Rows& rows) {
  Eigen::VectorXd first = Eigen::VectorXd::Zero(rows.A.cols());
  first(0) = first_slope(rows);
  return fit_rows(rows, first, kRelative);
}

/// Mean −2 log likelihood (but for a constant) of the spans [from, to) shifted by a lag, with Student's t for the
/// residuals, which a few wild ones do not move; nothing if too few are known.
std::optional<double> cost(const std::vector<Span>& spans, std::size_t from, std::size_t to, const Track& track,
                           double ratio, double lag, double scale) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t k = from; k < to; ++k) {
    const auto change = track.change(spans[k].from - lag, spans[k].to - lag);
    if (!change) continue;
    const double expected = ratio * *change;
    const double size = std::max(std::abs(spans[k].value), std::abs(expected));
    const double u = (spans[k].value - expected) / std::hypot(scale, kRelative * size);
    sum += (kFreedom + 1.0) * std::log1p(u * u / kFreedom);
    count += 1.0;
  }
  if (count < kLeastSpansOfPart) return std::nullopt;
  return sum / count;
}

/// Costs of a part of the log at all lags; empty if too little is known.
std::vector<double> costs_of(const std::vector<Span>& spans, std::size_t from, std::size_t to, const Track& track,
                             double ratio, double scale) {
  constexpr int kSteps = static_cast<int>(kMostLag / kLagStep);
  std::vector<double> costs;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const auto c = cost(spans, from, to, track, ratio, i * kLagStep, scale);
    if (!c) return {};
    costs.push_back(*c);
  }
  return costs;
}

/// Nothing if the least cost is at an end, or if every lag fits alike.
std::optional<double> least_cost(const std::vector<double>& costs, double step) {
  const auto best = std::ranges::min_element(costs);
  if (best == costs.begin() || best + 1 == costs.end()) return std::nullopt;
  const double bend = *(best - 1) - 2.0 * *best + *(best + 1);
  const double offset = bend > 0.0 ? 0.5 * (*(best - 1) - *(best + 1)) / bend : 0.0;
  const std::ptrdiff_t middle = std::ssize(costs) / 2;
  return step * (static_cast<double>(best - costs.begin() - middle) + offset);
}

/// The share of the numerator's large changes that the denominator has; nothing if there are few of them.
std::optional<Fit> share_of_turns(const Rows& rows, const Fit& fit) {
  Rows large(rows.count, 1);
  const Eigen::Index others = rows.A.cols() - 1;
  for (Eigen::Index k = 0; k < rows.count; ++k) {
    const double turn = rows.y(k) - rows.A.row(k).tail(others).dot(fit.x.tail(others));
    if (std::abs(turn) < kLargeTurn) continue;
    large.A(large.count, 0) = turn;
    large.y(large.count++) = rows.A(k, 0);
  }
  if (large.count < kLeastUnrelated) return std::nullopt;
  const Fit share = fit_rows(large);
  return share.valid ? std::optional(share) : std::nullopt;
}

/// True if either changes by much now and then: what stands still is unrelated by its noise alone.
bool has_turns(const Rows& rows) {
  const auto x = rows.A.col(0).head(rows.count).array();
  const auto y = rows.y.head(rows.count).array();
  const auto turns = [](const auto& changes) { return ((changes - changes.mean()).abs() > kClearTurn).count(); };
  return std::max(turns(x), turns(y)) >= kFewTurns;
}

/// Whether the bounds miss 1 by more than is usual.
void judge(Ratio& ratio, double tolerance) {
  const double size = std::max(std::abs(ratio.value), 1e-9);
  const double relative_sigma = ratio.sigma / size;
  // Relative to the larger one: 0.1 and 10 are equally far from 1.
  double beyond = 0.0;
  if (ratio.value < 0.0) {
    beyond = 1.0 - ratio.high;
  } else if (ratio.low > 1.0) {
    beyond = (ratio.low - 1.0) - tolerance;
  } else if (ratio.high < 1.0) {
    beyond = (1.0 / std::max(ratio.high, 1e-9) - 1.0) - tolerance;
  }
  ratio.sigmas =
      std::min(kMostSigmas, std::max(0.0, beyond) /
                                std::max(ratio.value > 1.0 || ratio.value < 0.0 ? ratio.sigma : relative_sigma, 1e-6));
  const bool is_sign = ratio.value < -0.5 && ratio.value > -2.0;
  if (beyond > 0.0 && ratio.sigmas > kSigmas && relative_sigma < (is_sign ? kDefiniteSign : kDefinite)) {
    ratio.verdict = Ratio::Verdict::differ;
  } else if (beyond <= 0.0 && (ratio.high - ratio.low) / size < kVague && relative_sigma < kVague / kSigmas) {
    ratio.verdict = Ratio::Verdict::agree;
  }
}

}  // namespace

std::vector<Span> spans_of(const Track& track, double length, double newest) {
  std::vector<Span> spans;
  for (double t = 0.0; t + length <= newest; t += length) {
    if (const auto change = track.change(t, t + length)) spans.push_back({t, t + length, *change});
  }
  return spans;
}

double best_shift(const std::vector<Span>& numerator, const Track& denominator) {
  double at_zero = 0.0;
  double best = 0.0;
  double shift = 0.0;
  constexpr int kSteps = static_cast<int>(kMostLag / kShiftStep);
  for (int i = -kSteps; i <= kSteps; ++i) {
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    long count = 0;
    for (const Span& span : numerator) {
      const auto change = denominator.change(span.from - i * kShiftStep, span.to - i * kShiftStep);
      if (!change) continue;
      // Wild ones, as from fix to fix, must not decide.
      const double x = std::clamp(*change, -kWild, kWild);
      const double y = std::clamp(span.value, -kWild, kWild);
      xx += x * x;
      xy += x * y;
      yy += y * y;
      ++count;
    }
    const double correlation2 = xx > 0.0 && yy > 0.0 && count > 30 ? xy * xy / (xx * yy) : 0.0;
    if (i == 0) at_zero = correlation2;
    if (correlation2 > best) {
      best = correlation2;
      shift = i * kShiftStep;
    }
  }
  return best > 2.0 * kUnrelated && 1.0 - best < kBetter * (1.0 - at_zero) ? shift : 0.0;
}

Ratio compare(const std::vector<Span>& numerator, const Track& denominator, const CompareOptions& options) {
  Ratio ratio;
  ratio.shift = options.shift;
  const auto rows_with = [&](bool time, bool way) {
    Rows rows(static_cast<Eigen::Index>(numerator.size()), 1 + (time ? 1 : 0) + (way ? 1 : 0));
    for (const Span& span : numerator) {
      const auto change = denominator.change(span.from - options.shift, span.to - options.shift);
      const auto driven = way ? options.way->change(span.from, span.to) : std::optional<double>(0.0);
      if (!change || !driven) continue;
      // The noise of a receiver's speed adds up, of a robot that stands still.
      const double length = kStill * (span.to - span.from);
      if (options.is_unsigned && std::abs(*change) < length && std::abs(span.value) < length) continue;
      rows.A(rows.count, 0) = options.is_unsigned ? std::abs(*change) : *change;
      if (time) rows.A(rows.count, 1) = span.to - span.from;
      if (way) rows.A(rows.count, rows.A.cols() - 1) = *driven;
      rows.y(rows.count) = options.is_unsigned ? std::abs(span.value) : span.value;
      ++rows.count;
    }
    return rows;
  };
  const bool has_way = options.way != nullptr && !options.is_unsigned;
  Rows rows = rows_with(!options.is_unsigned, has_way);
  ratio.spans = rows.count;
  if (rows.count == 0) return ratio;
  Fit fit = fit_ratio(rows);
  const auto is_way_vague = [&] { return !fit.valid || fit.sigma(fit.x.size() - 1) > kVaguePerWay; };
  bool knows_way = has_way;
  bool knows_time = !options.is_unsigned;
  if (has_way && is_way_vague()) {
    // At a constant speed way and time are the same; a bias is then taken for a turn per way.
    rows = rows_with(false, true);
    fit = fit_ratio(rows);
    knows_time = false;
    if (is_way_vague()) {
      knows_way = false;
      knows_time = true;
      rows = rows_with(true, false);
      fit = fit_ratio(rows);
    }
  }
  if (!fit.valid) return ratio;
  const SlopeBounds bounds = slope_bounds(rows, fit, 0);
  const bool is_one_sided = options.is_unsigned || options.is_noise_above;
  ratio.low = is_one_sided ? fit.x(0) : bounds.low;
  ratio.high = is_one_sided ? fit.x(0) : bounds.high;
  ratio.sigma = fit.sigma(0);
  ratio.value = std::copysign(std::sqrt(std::max(0.0, ratio.low * ratio.high)), ratio.low);
  if (knows_way) {
    ratio.per_way = fit.x(fit.x.size() - 1);
    ratio.per_way_sigma = fit.sigma(fit.x.size() - 1);
  }
  if (knows_time) {
    ratio.offset = fit.x(1);
    ratio.offset_sigma = fit.sigma(1);
  }
  if (!options.is_unsigned && bounds.correlation2 < kUnrelated) {
    const bool is_clear =
        ratio.spans >= kLeastUnrelated && has_turns(rows) && std::abs(fit.x(0)) + kSigmas * ratio.sigma < kMostShare;
    if (is_clear) {
      ratio.verdict = Ratio::Verdict::unrelated;
      ratio.value = fit.x(0);
      ratio.sigmas = (1.0 - std::abs(fit.x(0))) / std::max(ratio.sigma, 1e-6);
      return ratio;
    }
    // A gyro whose axis does not point up hardly changes at all: no slope on it is known.
    const auto share = options.is_sure ? share_of_turns(rows, fit) : std::nullopt;
    if (share && std::abs(share->x(0)) + kSigmas * share->sigma(0) < kMostShare) {
      ratio.verdict = Ratio::Verdict::unrelated;
      ratio.value = 0.0;
      ratio.sigmas = (1.0 - std::abs(share->x(0))) / std::max(share->sigma(0), 1e-6);
    }
    return ratio;
  }
  judge(ratio, options.tolerance);
  return ratio;
}

Lag find_lag(const std::vector<Span>& measured, const Track& track, double ratio) {
  Lag lag;
  std::vector<double> rates;
  for (const Span& span : measured) {
    if (const auto change = track.change(span.from, span.to))
      rates.push_back((span.value - ratio * *change) / (span.to - span.from));
  }
  if (rates.size() < kParts * static_cast<std::size_t>(kLeastSpansOfPart)) return lag;
  // The bias of a gyro, or wheels of unequal size, at the usual speed.
  const double bias = median(rates);
  std::vector<Span> late = measured;
  for (Span& span : late) span.value -= bias * (span.to - span.from);
  std::vector<double> residuals;
  for (const Span& span : late) {
    if (const auto change = track.change(span.from, span.to))
      residuals.push_back(std::abs(span.value - ratio * *change));
  }
  const double scale = kMadToSigma * median(residuals);
  if (!(scale > 0.0)) return lag;
  std::vector<std::vector<double>> parts;
  for (std::size_t p = 0; p < kParts; ++p) {
    std::vector<double> costs =
        costs_of(late, late.size() * p / kParts, late.size() * (p + 1) / kParts, track, ratio, scale);
    if (!costs.empty()) parts.push_back(std::move(costs));
  }
  return lag_of(parts, kLagStep);
}

Lag lag_of(const std::vector<std::vector<double>>& costs, double step) {
  Lag lag;
  if (costs.size() < kLeastParts) return lag;
  std::vector<double> sum(costs.front().size(), 0.0);
  const auto add = [&](std::vector<double>& to, const std::vector<double>& part, double sign) {
    for (std::size_t k = 0; k < to.size(); ++k) to[k] += sign * part[k];
  };
  for (const auto& part : costs) add(sum, part, 1.0);
  const auto all = least_cost(sum, step);
  const auto n = static_cast<double>(costs.size());
  const auto [least, most] = std::ranges::minmax(sum);
  if (!all || most - least < n * kClear) return lag;
  double squares = 0.0;
  for (const auto& part : costs) {
    std::vector<double> without = sum;
    add(without, part, -1.0);
    const auto value = least_cost(without, step);
    if (!value) return lag;
    squares += (*value - *all) * (*value - *all);
  }
  lag.value = *all;
  lag.sigma = std::max(std::sqrt((n - 1.0) / n * squares), 0.1 * step);
  lag.is_known = true;
  return lag;
}

}  // namespace waymark::host::diagnosis
