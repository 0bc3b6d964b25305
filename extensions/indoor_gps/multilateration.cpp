// SPDX-License-Identifier: Apache-2.0
#include "multilateration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "waymark/math/gaussian.hpp"

namespace waymark::indoor_gps {
namespace {

using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRanges, kMaxRanges>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxRanges, 1>;
using Design = Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxRanges, 2>;
using ByBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRanges, kMaxBlockStates>;

constexpr double kSameSolution = 3.0;     // σ between two solutions that count as one
constexpr double kBetter = 10.0;          // by so much χ² the best solution must beat any other
constexpr double kAgreement = 0.999;      // χ² quantile beyond which ranges contradict each other
constexpr double kLargestPerRange = 0.3;  // σ per distance to the nearest beacon: the circles count as straight

/// The ranges linearised at a point.
struct Linearized {
  Column residual;
  Design J;
  Square white;  ///< noise covariance without scale and offset
  Square whole;  ///< with them
  double nearest = std::numeric_limits<double>::infinity();
};

Linearized linearize(const Beacons& beacons, std::span<const RangeRow> ranges, const Eigen::Vector3d& p) {
  const auto n = static_cast<Eigen::Index>(ranges.size());
  Linearized out;
  out.residual.resize(n);
  out.J.resize(n, 2);
  out.white.setZero(n, n);
  ByBlock B(n, beacons.block_size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const RangeRow& range = ranges[static_cast<std::size_t>(i)];
    const ExpectedRange expected = beacons.expect(range.beacon, range.reference, p, nullptr);
    out.residual[i] = range.value - expected.value;
    out.J.row(i) = expected.by_point.head<2>();
    B.row(i) = expected.by_block;
    out.white(i, i) = range.variance;
    const Eigen::Vector3d& b = beacons.all()[static_cast<std::size_t>(range.beacon)].p_map;
    out.nearest = std::min(out.nearest, (p - b).head<2>().norm());
  }
  out.whole = out.white;
  const StateBlock block = beacons.block();
  for (Eigen::Index k = 0; k < B.cols(); ++k) {
    const double sigma = block[static_cast<std::size_t>(k)].initial_sigma;
    out.whole += sigma * sigma * B.col(k) * B.col(k).transpose();
  }
  return out;
}

struct Solution {
  Eigen::Vector2d p;
  double chi_squared;
  Eigen::Matrix2d covariance;
  double white_variance;  ///< in its worst direction, without scale and offset
  double nearest;         ///< to the nearest beacon [m]
};

/// (JᵀC⁻¹J)⁻¹.
Eigen::Matrix2d covariance(const Design& J, const Square& C) {
  const Design weighted = C.llt().solve(J);
  return (J.transpose() * weighted).inverse();
}

double largest(const Eigen::Matrix2d& P) {
  const double mean = 0.5 * P.trace();
  return mean + std::sqrt(std::max(0.0, mean * mean - P.determinant()));
}

std::optional<Solution> descend(const Beacons& beacons, std::span<const RangeRow> ranges, Eigen::Vector2d p,
                                double z_map) {
  constexpr int kIterations = 30;
  constexpr double kConverged = 1e-4;  // [m]
  for (int i = 0; i < kIterations; ++i) {
    const Linearized at = linearize(beacons, ranges, {p.x(), p.y(), z_map});
    const Eigen::LLT<Square> factor(at.whole);
    const Eigen::Matrix2d P = covariance(at.J, at.whole);
    if (factor.info() != Eigen::Success || !P.allFinite() || P.determinant() <= 0.0) return std::nullopt;
    const Column weighted = factor.solve(at.residual);
    Eigen::Vector2d step = P * (at.J.transpose() * weighted);
    // Where a range is much longer than the distance the tangent leads far beyond the circle.
    const double longest = std::max(1.0, at.residual.cwiseAbs().maxCoeff());
    if (step.norm() > longest) step *= longest / step.norm();
    if (!step.allFinite()) return std::nullopt;
    p += step;
    if (step.norm() > kConverged) continue;
    const Linearized end = linearize(beacons, ranges, {p.x(), p.y(), z_map});
    const Column last = end.whole.llt().solve(end.residual);
    return Solution{p, end.residual.dot(last), P, largest(covariance(end.J, end.white)), end.nearest};
  }
  return std::nullopt;
}

/// Where a search begins: the beacons' centre, and where two circles meet, or come nearest to each other; of each
/// beacon the last range, since those before it lie beside it.
std::vector<Eigen::Vector2d> beginnings(const Beacons& beacons, std::span<const RangeRow> ranges) {
  std::vector<Eigen::Vector2d> out;
  out.reserve(1 + ranges.size() * ranges.size());
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Beacon& beacon : beacons.all())
    centre += beacon.p_map.head<2>() / static_cast<double>(beacons.all().size());
  out.push_back(centre);
  const auto begins = [&](std::size_t i) {
    const auto after = ranges.subspan(i + 1);
    return ranges[i].reference < 0 && std::ranges::find(after, ranges[i].beacon, &RangeRow::beacon) == after.end();
  };
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!begins(i) || !begins(j)) continue;
      const Eigen::Vector2d a = beacons.all()[static_cast<std::size_t>(ranges[i].beacon)].p_map.head<2>();
      const Eigen::Vector2d d = beacons.all()[static_cast<std::size_t>(ranges[j].beacon)].p_map.head<2>() - a;
      const double apart = d.norm();
      if (apart < 1e-3) continue;
      const double ra = ranges[i].value;
      const double rb = ranges[j].value;
      const double along = std::clamp((ra * ra - rb * rb + apart * apart) / (2.0 * apart), -ra, ra);
      const double across = std::sqrt(std::max(0.0, ra * ra - along * along));
      const Eigen::Vector2d unit = d / apart;
      const Eigen::Vector2d normal(-unit.y(), unit.x());
      out.emplace_back(a + along * unit + across * normal);
      out.emplace_back(a + along * unit - across * normal);
    }
  }
  return out;
}

int distinct_beacons(std::span<const RangeRow> ranges) {
  int count = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto before = ranges.first(i);
    if (std::ranges::find(before, ranges[i].beacon, &RangeRow::beacon) == before.end()) ++count;
  }
  return count;
}

}  // namespace

std::optional<RangedPosition> multilaterate(const Beacons& beacons, std::span<const RangeRow> ranges, double z_map) {
  constexpr int kFewest = 3;
  if (ranges.size() > static_cast<std::size_t>(kMaxRanges)) ranges = ranges.last(kMaxRanges);
  if (distinct_beacons(ranges) < kFewest) return std::nullopt;
  std::vector<Solution> solutions;
  solutions.reserve(1 + ranges.size() * ranges.size());
  for (const Eigen::Vector2d& begin : beginnings(beacons, ranges)) {
    if (const auto found = descend(beacons, ranges, begin, z_map)) solutions.push_back(*found);
  }
  if (solutions.empty()) return std::nullopt;
  const Solution best = *std::ranges::min_element(solutions, {}, &Solution::chi_squared);
  const double sigma = std::sqrt(largest(best.covariance));
  const bool is_ambiguous = std::ranges::any_of(solutions, [&](const Solution& other) {
    return (other.p - best.p).norm() > kSameSolution * sigma && other.chi_squared < best.chi_squared + kBetter;
  });
  const int spare = static_cast<int>(ranges.size()) - 2;
  if (is_ambiguous || best.chi_squared > gaussian::chi_squared_quantile(kAgreement, spare)) return std::nullopt;
  if (!(sigma < kLargestPerRange * best.nearest)) return std::nullopt;
  const double slow = std::sqrt(std::max(0.0, sigma * sigma - best.white_variance));
  return RangedPosition{best.p, sigma, slow};
}

}  // namespace waymark::indoor_gps
