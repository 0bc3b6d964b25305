// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/nearby_landmarks.hpp"

#include <algorithm>
#include <limits>

namespace waymark::feature_map {

namespace {

constexpr std::size_t kBlock = 16;
constexpr float kNowhere = 1e18f;
constexpr double kRelativeSlack = 1e-3;

}  // namespace

void NearbyLandmarks::gather(const LandmarkStore& store, const Eigen::Vector2d& center, double reach) {
  entries_.clear();
  center_ = center;
  store.for_near(center, reach, [&](LandmarkRef ref, StoredLandmark landmark) {
    entries_.push_back({ref, landmark, false});
  });
  const std::size_t padded = (entries_.size() + kBlock - 1) / kBlock * kBlock;
  east_.resize(padded);
  north_.resize(padded);
  variance_.resize(padded);
  for (std::size_t n = 0; n < entries_.size(); ++n) {
    const StoredLandmark& landmark = entries_[n].landmark;
    east_[n] = static_cast<float>(landmark.east() - center.x());
    north_[n] = static_cast<float>(landmark.north() - center.y());
    variance_[n] = static_cast<float>(landmark.position_variance());
  }
  for (std::size_t n = entries_.size(); n < padded; ++n) {
    east_[n] = north_[n] = kNowhere;
    variance_[n] = 0.0f;
  }
  // A distance d comes out wrong by at most e, so d² by 2 d e + e² <= s d² + (1 + 1/s) e² for any s.
  const double e = 4.0 * std::numeric_limits<float>::epsilon() * (reach + 1.0);
  slack_ = (1.0 + 1.0 / kRelativeSlack) * e * e;
}

std::span<const std::uint32_t> NearbyLandmarks::within(const Eigen::Vector2d& p, double base, double share) {
  found_.clear();
  const auto x = static_cast<float>(p.x() - center_.x());
  const auto y = static_cast<float>(p.y() - center_.y());
  const auto constant = static_cast<float>((1.0 + 2.0 * kRelativeSlack) * base + slack_);
  const auto factor = static_cast<float>((1.0 + 2.0 * kRelativeSlack) * share);
  // Most blocks hold nothing near, so the block's least difference is taken first, in vector instructions.
  using Block = Eigen::Map<const Eigen::Array<float, kBlock, 1>>;
  for (std::size_t first = 0; first < east_.size(); first += kBlock) {
    const Eigen::Array<float, kBlock, 1> dx = Block(east_.data() + first) - x;
    const Eigen::Array<float, kBlock, 1> dy = Block(north_.data() + first) - y;
    const Eigen::Array<float, kBlock, 1> excess = dx * dx + dy * dy - factor * Block(variance_.data() + first);
    if (excess.minCoeff() > constant) continue;
    const std::size_t last = std::min(first + kBlock, entries_.size());
    for (std::size_t n = first; n < last; ++n) {
      if (excess[static_cast<Eigen::Index>(n - first)] <= constant) found_.push_back(static_cast<std::uint32_t>(n));
    }
  }
  return found_;
}

}  // namespace waymark::feature_map
