// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "map_modules/feature_map/landmarks/landmark.hpp"

namespace waymark::feature_map {

/// An axis-aligned box in floats, rounded outwards: what is inside it in doubles is inside it here.
struct LandmarkBox {
  float low_east = std::numeric_limits<float>::infinity();
  float low_north = std::numeric_limits<float>::infinity();
  float high_east = -std::numeric_limits<float>::infinity();
  float high_north = -std::numeric_limits<float>::infinity();

  void include(double east, double north);
  void include(const LandmarkBox& other);
  bool contains(const LandmarkBox& other) const;
  /// Width plus height [m], of the box or of the box grown to `east`, `north`.
  double half_perimeter() const;
  double half_perimeter_with(double east, double north) const;
  bool is_wider_than_high() const { return high_east - low_east > high_north - low_north; }
  /// Squared distance from a point to the nearest and to the farthest place of the box [m²].
  double nearest_square(double east, double north) const {
    const double x = std::max({low_east - east, east - high_east, 0.0});
    const double y = std::max({low_north - north, north - high_north, 0.0});
    return x * x + y * y;
  }
  double farthest_square(double east, double north) const {
    const double x = std::max(east - low_east, high_east - east);
    const double y = std::max(north - low_north, high_north - north);
    return x * x + y * y;
  }
};

/// Neighbouring landmarks as a structure of arrays: a leaf of `LandmarkStore`. A place is in use if its bit in `used`
/// is set.
struct LandmarkLeaf {
  static constexpr int kSize = 32;
  template <class T>
  using Column = std::array<T, kSize>;

  std::uint32_t used = 0;
  Column<double> east{};                       ///< [m]
  Column<double> north{};                      ///< [m]
  Column<double> radius{};                     ///< [m]
  std::array<Column<double>, 6> covariance{};  ///< of (east, north, radius): ee, en, nn, er, nr, rr
  std::array<Column<double>, 3> floor{};       ///< `Landmark::P_floor`: ee, en, nn
  Column<std::int64_t> id{};
  Column<std::uint64_t> birth{};
  Column<Time> last_seen{};
  Column<float> log_odds{};
  Column<std::int32_t> sightings{};
  Column<std::int32_t> identity{};
  Column<std::uint8_t> bins{};      ///< of each signature; 0: unknown
  Column<std::int32_t> views{};     ///< fused into each signature
  std::uint32_t bins_reserved = 0;  ///< room per place in `signatures`
  std::vector<float> signatures;    ///< bins_reserved floats per place; empty if no landmark has a signature

  int count() const { return std::popcount(used); }
  bool has(int place) const { return ((used >> static_cast<unsigned>(place)) & 1u) != 0; }
  /// The lowest free place, or kSize.
  int free_place() const { return std::countr_one(used); }

  void put(int place, const Landmark& landmark);
  Landmark get(int place) const;
  void free(int place) { used &= ~(1u << static_cast<unsigned>(place)); }
  std::span<const float> signature(int place) const {
    return {signatures.data() + static_cast<std::size_t>(place) * bins_reserved, bins[static_cast<std::size_t>(place)]};
  }
  LandmarkBox box() const;
  /// Bytes of the leaf and of the block of signatures.
  std::size_t bytes() const { return sizeof(LandmarkLeaf) + signatures.capacity() * sizeof(float); }
};

/// Reads one landmark where it is stored. Valid until its store is written or destroyed.
class StoredLandmark {
 public:
  StoredLandmark(const LandmarkLeaf& leaf, int place) : leaf_(&leaf), place_(static_cast<std::size_t>(place)) {}

  double east() const { return leaf_->east[place_]; }
  double north() const { return leaf_->north[place_]; }
  double radius() const { return leaf_->radius[place_]; }
  Eigen::Vector3d mean() const { return {east(), north(), radius()}; }
  Eigen::Matrix3d covariance() const {
    const auto& c = leaf_->covariance;
    Eigen::Matrix3d P;
    P << c[0][place_], c[1][place_], c[3][place_],  //
        c[1][place_], c[2][place_], c[4][place_],   //
        c[3][place_], c[4][place_], c[5][place_];
    return P;
  }
  /// Trace of the position's covariance [m²].
  double position_variance() const { return leaf_->covariance[0][place_] + leaf_->covariance[2][place_]; }
  std::span<const float> signature() const { return leaf_->signature(static_cast<int>(place_)); }
  std::int32_t identity() const { return leaf_->identity[place_]; }
  float log_odds() const { return leaf_->log_odds[place_]; }
  std::int32_t sightings() const { return leaf_->sightings[place_]; }
  std::int64_t id() const { return leaf_->id[place_]; }
  std::uint64_t birth() const { return leaf_->birth[place_]; }
  Time last_seen() const { return leaf_->last_seen[place_]; }

  /// All of it, as a copy.
  operator Landmark() const { return leaf_->get(static_cast<int>(place_)); }  // NOLINT(google-explicit-constructor)

 private:
  const LandmarkLeaf* leaf_;
  std::size_t place_;
};

}  // namespace waymark::feature_map
