// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kBlock = 20.0;  // [s]
constexpr std::size_t kLeastFixes = 10;
constexpr std::size_t kLeastBlocks = 6;
constexpr double kFarthest = 30.0;  // [s]
constexpr double kStep = 0.25;      // [s]
constexpr double kNear = 1.9;       // [s]: smaller differences are the business of check_delays
constexpr double kFloor = 0.1;      // [m] of what is left: less proves nothing
constexpr double kBetter = 0.7;     // of the logarithm of what is left, as a mean over the blocks
constexpr double kSigmas = 4.0;

using Block = std::pair<std::vector<Fix>::const_iterator, std::vector<Fix>::const_iterator>;

std::vector<Block> blocks_of(const std::vector<Fix>& fixes) {
  std::vector<Block> blocks;
  auto begin = fixes.begin();
  for (auto fix = fixes.begin(); fix != fixes.end(); ++fix) {
    if (fix->t - begin->t < kBlock) continue;
    if (fix - begin >= static_cast<std::ptrdiff_t>(kLeastFixes)) blocks.emplace_back(begin, fix);
    begin = fix;
  }
  return blocks;
}

/// Logarithm of what is left of the positions, squared, beside the velocity summed up, if its stamps are `behind`
/// those of the positions; nothing if it is not known throughout.
std::optional<double> left_of(const Block& block, const WatchedSensor& receiver, double behind) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0.0;
  double n = 0.0;
  for (auto fix = block.first; fix != block.second; ++fix) {
    const auto east = receiver.velocity_east.change(block.first->t + behind, fix->t + behind);
    const auto north = receiver.velocity_north.change(block.first->t + behind, fix->t + behind);
    if (!east || !north) return std::nullopt;
    const Eigen::Vector2d rest = fix->p - block.first->p - Eigen::Vector2d(*east, *north);
    sum += rest;
    squares += rest.squaredNorm();
    n += 1.0;
  }
  return std::log(std::max(squares - sum.squaredNorm() / n, 0.0) / n + kFloor * kFloor);
}

/// How much less is left than with the stamps as they are, over the blocks.
struct Gain {
  double mean = 0.0;
  double sigma = 0.0;
};

/// What is left of each block beside the velocity that is so far behind.
std::vector<std::optional<double>> left_of_each(const std::vector<Block>& blocks, const WatchedSensor& receiver,
                                                double behind) {
  std::vector<std::optional<double>> left;
  left.reserve(blocks.size());
  for (const Block& block : blocks) left.push_back(left_of(block, receiver, behind));
  return left;
}

std::optional<Gain> gain_of(const std::vector<std::optional<double>>& as_given,
                            const std::vector<std::optional<double>>& shifted) {
  std::vector<double> gains;
  for (std::size_t k = 0; k < as_given.size(); ++k) {
    if (as_given[k] && shifted[k]) gains.push_back(*as_given[k] - *shifted[k]);
  }
  if (gains.size() < kLeastBlocks) return std::nullopt;
  const auto n = static_cast<double>(gains.size());
  Gain gain;
  for (const double one : gains) gain.mean += one / n;
  for (const double one : gains) gain.sigma += (one - gain.mean) * (one - gain.mean);
  gain.sigma = std::sqrt(gain.sigma / (n * (n - 1.0)));
  return gain;
}

}  // namespace

void check_own_velocities(Case& c) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    if (sensor.fixes.empty() || sensor.velocity_east.samples() == 0 || c.is_concerned(i)) continue;
    const std::vector<Block> blocks = blocks_of(sensor.fixes);
    const auto as_given = left_of_each(blocks, sensor, 0.0);
    Gain best;
    double behind = 0.0;
    for (double tried = -kFarthest; tried <= kFarthest; tried += kStep) {
      const auto gain = gain_of(as_given, left_of_each(blocks, sensor, tried));
      if (!gain || gain->mean <= best.mean) continue;
      best = *gain;
      behind = tried;
    }
    if (std::abs(behind) < kNear || best.mean < kBetter || best.mean < kSigmas * best.sigma) continue;
    c.add(
        Finding::Certainty::named, "delay", {i},
        fmt::format("its course and speed are {:.1f} s {} its positions", std::abs(behind),
                    behind > 0.0 ? "behind" : "ahead of"),
        fmt::format("source: course and speed of {}: another message of the receiver, or leave them out", sensor.name),
        best.mean / std::max(best.sigma, 1e-3));
  }
}

}  // namespace waymark::host::diagnosis
