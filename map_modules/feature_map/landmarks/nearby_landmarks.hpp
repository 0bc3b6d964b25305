// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "map_modules/feature_map/landmarks/landmark_store.hpp"

namespace waymark::feature_map {

/// The landmarks of one particle that may matter to one scan, gathered once, with what a first, cheap bound needs in
/// contiguous floats. Reuses its storage.
class NearbyLandmarks {
 public:
  struct Entry {
    LandmarkRef ref;
    StoredLandmark landmark;  ///< valid until the store is written
    bool taken = false;       ///< by a detection
  };

  /// Forgets what was there and gathers all landmarks within `reach` of `center`.
  void gather(const LandmarkStore& store, const Eigen::Vector2d& center, double reach);

  std::size_t size() const { return entries_.size(); }
  const Entry& operator[](std::size_t n) const { return entries_[n]; }
  Entry& operator[](std::size_t n) { return entries_[n]; }
  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }

  /// Indices, in order, of all landmarks with |p − position|² <= base + share · trace(position's covariance), and of
  /// a few more, since the test is in floats with slack for their rounding. Valid until the next call.
  std::span<const std::uint32_t> within(const Eigen::Vector2d& p, double base, double share);

 private:
  std::vector<Entry> entries_;
  Eigen::Vector2d center_ = Eigen::Vector2d::Zero();
  double slack_ = 0.0;
  // Relative to center_; padded to whole blocks.
  std::vector<float> east_;
  std::vector<float> north_;
  std::vector<float> variance_;
  std::vector<std::uint32_t> found_;
};

}  // namespace waymark::feature_map
