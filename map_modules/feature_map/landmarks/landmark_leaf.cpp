// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/landmark_leaf.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace waymark::feature_map {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float rounded_down(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest > value ? std::nextafter(nearest, -kInfinity) : nearest;
}

float rounded_up(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest < value ? std::nextafter(nearest, kInfinity) : nearest;
}

}  // namespace

void LandmarkBox::include(double east, double north) {
  low_east = std::min(low_east, rounded_down(east));
  low_north = std::min(low_north, rounded_down(north));
  high_east = std::max(high_east, rounded_up(east));
  high_north = std::max(high_north, rounded_up(north));
}

void LandmarkBox::include(const LandmarkBox& other) {
  low_east = std::min(low_east, other.low_east);
  low_north = std::min(low_north, other.low_north);
  high_east = std::max(high_east, other.high_east);
  high_north = std::max(high_north, other.high_north);
}

bool LandmarkBox::contains(const LandmarkBox& other) const {
  return low_east <= other.low_east && low_north <= other.low_north && high_east >= other.high_east &&
         high_north >= other.high_north;
}

double LandmarkBox::half_perimeter() const {
  return (static_cast<double>(high_east) - low_east) + (static_cast<double>(high_north) - low_north);
}

double LandmarkBox::half_perimeter_with(double east, double north) const {
  return (std::max<double>(high_east, east) - std::min<double>(low_east, east)) +
         (std::max<double>(high_north, north) - std::min<double>(low_north, north));
}

void LandmarkLeaf::put(int place, const Landmark& landmark) {
  const auto i = static_cast<std::size_t>(place);
  used |= 1u << static_cast<unsigned>(place);
  east[i] = landmark.mean.x();
  north[i] = landmark.mean.y();
  radius[i] = landmark.mean.z();
  const Eigen::Matrix3d& P = landmark.P;
  const std::array<double, 6> terms = {P(0, 0), P(0, 1), P(1, 1), P(0, 2), P(1, 2), P(2, 2)};
  for (std::size_t t = 0; t < terms.size(); ++t) covariance[t][i] = terms[t];
  floor[0][i] = landmark.P_floor(0, 0);
  floor[1][i] = landmark.P_floor(0, 1);
  floor[2][i] = landmark.P_floor(1, 1);
  id[i] = landmark.id;
  birth[i] = landmark.birth;
  last_seen[i] = landmark.last_seen;
  log_odds[i] = landmark.log_odds;
  sightings[i] = landmark.sightings;
  identity[i] = landmark.identity;
  bins[i] = static_cast<std::uint8_t>(landmark.signature.size());
  views[i] = landmark.signature_views;
  if (landmark.signature.size() > bins_reserved) {
    const std::size_t wider = landmark.signature.size();
    std::vector<float> block(kSize * wider, 0.0f);
    for (std::size_t p = 0; p < kSize && bins_reserved > 0; ++p) {
      std::copy_n(signatures.begin() + static_cast<std::ptrdiff_t>(p * bins_reserved), bins_reserved,
                  block.begin() + static_cast<std::ptrdiff_t>(p * wider));
    }
    signatures = std::move(block);
    bins_reserved = static_cast<std::uint32_t>(wider);
  }
  std::copy(landmark.signature.begin(), landmark.signature.end(),
            signatures.begin() + static_cast<std::ptrdiff_t>(i * bins_reserved));
}

Landmark LandmarkLeaf::get(int place) const {
  const auto i = static_cast<std::size_t>(place);
  const StoredLandmark stored(*this, place);
  Landmark landmark;
  landmark.mean = stored.mean();
  landmark.P = stored.covariance();
  landmark.P_floor << floor[0][i], floor[1][i], floor[1][i], floor[2][i];
  const std::span<const float> histogram = signature(place);
  if (!histogram.empty()) landmark.signature = Signature::uniform(histogram.size());
  std::copy(histogram.begin(), histogram.end(), landmark.signature.begin());
  landmark.signature_views = views[i];
  landmark.identity = identity[i];
  landmark.log_odds = log_odds[i];
  landmark.sightings = sightings[i];
  landmark.id = id[i];
  landmark.birth = birth[i];
  landmark.last_seen = last_seen[i];
  return landmark;
}

LandmarkBox LandmarkLeaf::box() const {
  double low_east = std::numeric_limits<double>::infinity();
  double low_north = low_east;
  double high_east = -low_east;
  double high_north = -low_east;
  for (std::uint32_t left = used; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    low_east = std::min(low_east, east[i]);
    low_north = std::min(low_north, north[i]);
    high_east = std::max(high_east, east[i]);
    high_north = std::max(high_north, north[i]);
  }
  LandmarkBox box;
  if (used == 0) return box;
  box.include(low_east, low_north);
  box.include(high_east, high_north);
  return box;
}

}  // namespace waymark::feature_map
