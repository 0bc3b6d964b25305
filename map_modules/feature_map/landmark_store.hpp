// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "feature_observation.hpp"
#include "waymark/archive.hpp"
#include "waymark/cow.hpp"

namespace waymark {

/// An augmented landmark: (east, north, radius) with one covariance, a signature, and whether it exists (§4).
struct Landmark {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< (east, north, radius) [m]
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Eigen::Matrix2d P_floor = Eigen::Matrix2d::Zero();  ///< what the position can never be known better than: the pose's
                                                      ///< own covariance when it was written
  Signature signature;
  std::int32_t identity = -1;  ///< the one that made it, where devices read identities; -1: unknown
  float log_odds = 0.0f;
  std::int32_t sightings = 0;
  std::int64_t id = -1;  ///< -1: an empty place
};

/// Where a landmark lies: chunk and place in it.
struct LandmarkRef {
  std::int32_t chunk = -1;
  std::int32_t place = -1;
};

/// A particle's landmarks in small chunks of neighbours. Copying the store copies one handle; a write clones the
/// directory of handles once and the chunk that is written, if others share them.
class LandmarkStore {
 public:
  static constexpr int kChunkSize = 16;

  std::size_t size() const { return directory_->count; }
  const Landmark& at(LandmarkRef ref) const {
    return directory_->entries[static_cast<std::size_t>(ref.chunk)].chunk->places[static_cast<std::size_t>(ref.place)];
  }

  /// Calls visit(ref, landmark) for all landmarks within `radius` of `center`, in a fixed order.
  template <class Visit>
  void for_near(const Eigen::Vector2d& center, double radius, const Visit& visit) const {
    const std::vector<Entry>& entries = directory_->entries;
    for (std::size_t c = 0; c < entries.size(); ++c) {
      if (entries[c].used == 0 || entries[c].box.distance(center) > radius) continue;
      const auto& places = entries[c].chunk->places;
      for (std::size_t i = 0; i < places.size(); ++i) {
        if (places[i].id >= 0 && (places[i].mean.head<2>() - center).squaredNorm() <= radius * radius) {
          visit(LandmarkRef{static_cast<std::int32_t>(c), static_cast<std::int32_t>(i)}, places[i]);
        }
      }
    }
  }
  template <class Visit>
  void for_all(const Visit& visit) const {
    for (const Entry& entry : directory_->entries) {
      for (const Landmark& landmark : entry.chunk->places) {
        if (landmark.id >= 0) visit(landmark);
      }
    }
  }

  /// Adds a landmark under a fresh id and returns that.
  std::int64_t add(Landmark landmark);
  /// Replaces a landmark; its id stays.
  void write(LandmarkRef ref, const Landmark& landmark);
  void erase(LandmarkRef ref);

  void save(OutArchive& out) const;
  void load(InArchive& in);

  /// Chunks that this store does not share with `other`, for tests of copy-on-write.
  int chunks_not_shared_with(const LandmarkStore& other) const;

 private:
  struct Chunk {
    std::array<Landmark, kChunkSize> places;
  };
  struct Box {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
    Eigen::Vector2d high = Eigen::Vector2d::Constant(-1e300);
    void include(const Eigen::Vector2d& p) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    double distance(const Eigen::Vector2d& p) const { return (low - p).cwiseMax(p - high).cwiseMax(0.0).norm(); }
  };
  struct Entry {
    Box box;
    int used = 0;
    Cow<Chunk> chunk;
  };
  struct Directory {
    std::vector<Entry> entries;
    std::size_t count = 0;
    std::int64_t next_id = 0;
  };

  Cow<Directory> directory_;
};

}  // namespace waymark
