// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/allan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace waymark::calibration {

namespace {

constexpr double kShortestSeconds = 0.1;  // faster noise is often filtered within the device
constexpr double kLongestSeconds = 2.0;   // slower noise is the walk of the bias
constexpr double kKnown = 1.0 / 3.0;

}  // namespace

std::vector<AllanPoint> allan_deviation(const std::vector<double>& samples, double period_s) {
  std::vector<double> sums{0.0};
  sums.reserve(samples.size() + 1);
  for (const double sample : samples) sums.push_back(sums.back() + sample);
  std::vector<AllanPoint> points;
  for (std::size_t decade = 1;; decade *= 10) {
    for (const std::size_t part : std::array<std::size_t, 3>{1, 2, 5}) {
      const std::size_t length = decade * part;
      if (length * 9 > samples.size()) return points;
      double sum = 0.0;
      std::size_t count = 0;
      for (std::size_t i = 0; i + 2 * length < sums.size(); ++i, ++count) {
        const double difference = (sums[i + 2 * length] - 2.0 * sums[i + length] + sums[i]);
        sum += difference * difference;
      }
      const double deviation = std::sqrt(0.5 * sum / static_cast<double>(count)) / static_cast<double>(length);
      const double independent = static_cast<double>(samples.size()) / static_cast<double>(length) - 1.0;
      points.push_back({static_cast<double>(length) * period_s, deviation, 1.0 / std::sqrt(2.0 * independent)});
    }
  }
}

WhiteNoise white_noise(const std::vector<AllanPoint>& points) {
  WhiteNoise noise;
  double weights = 0.0;
  double share = 0.0;
  for (const AllanPoint& point : points) {
    if (point.tau_s < kShortestSeconds || point.tau_s > kLongestSeconds) continue;
    noise.density += point.deviation * std::sqrt(point.tau_s);
    share = std::max(share, point.share);
    weights += 1.0;
  }
  if (weights == 0.0) return {};
  noise.density /= weights;
  noise.sigma = noise.density * share;  // that of the longest time: the others repeat the same samples
  return noise;
}

AllanPoint lowest(const std::vector<AllanPoint>& points) {
  AllanPoint best{0.0, 0.0, 1.0};
  for (const AllanPoint& point : points) {
    if (point.share <= kKnown && (best.tau_s == 0.0 || point.deviation < best.deviation)) best = point;
  }
  return best;
}

}  // namespace waymark::calibration
