// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/merging.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace waymark::feature_map {

namespace {

// More of them never come so close to one landmark in one step; what is left over is merged in the next.
constexpr std::size_t kMostPartners = 4;

struct Partners {
  std::array<LandmarkRef, kMostPartners> refs;
  std::size_t count = 0;
};

template <int D>
bool agree(const StoredLandmark& a, const StoredLandmark& b, double gate) {
  const Eigen::Matrix<double, D, 1> nu = (a.mean() - b.mean()).head<D>();
  const Eigen::Matrix<double, D, D> S = (a.covariance() + b.covariance()).template topLeftCorner<D, D>();
  return nu.dot(S.inverse() * nu) <= gate;
}

bool may_be_one(const StoredLandmark& a, const StoredLandmark& b, const FeatureMapSettings& settings) {
  if (a.identity() >= 0 && b.identity() >= 0 && a.identity() != b.identity()) return false;
  const double gate = settings.association.gate;
  return settings.use_radius ? agree<3>(a, b, gate) : agree<2>(a, b, gate);
}

Partners partners_of(const LandmarkStore& store, const FeatureMapSettings& settings, LandmarkRef ref,
                     std::span<const LandmarkRef> written) {
  Partners partners;
  const StoredLandmark landmark = store.stored(ref);
  store.for_near({landmark.east(), landmark.north()}, settings.association.min_separation,
                 [&](LandmarkRef other_ref, const StoredLandmark& other) {
                   if (partners.count == kMostPartners || !may_be_one(landmark, other, settings)) return;
                   if (std::ranges::find(written, other_ref) != written.end()) return;  // `ref` itself is one of them
                   partners.refs[partners.count++] = other_ref;
                 });
  return partners;
}

/// The better known of the two, with the sightings of both. Its mean and covariance stay as they are: both landmarks
/// were written from the same chain of poses, so their errors are correlated to an unknown degree, and fusing them as
/// independent would count the common part twice. Covariance intersection (S. Julier, J. Uhlmann, ACC 1997) is
/// consistent for any correlation, and with its weight at the better known one it is just that one. Sightings and
/// log-odds do add up, since every detection and every miss was counted in only one of the two.
Landmark merged(const Landmark& a, const Landmark& b, const FeatureMapSettings& settings) {
  const double a_variance = a.P.topLeftCorner<2, 2>().trace();
  const double b_variance = b.P.topLeftCorner<2, 2>().trace();
  const bool a_stays = a_variance != b_variance ? a_variance < b_variance : a.id < b.id;
  Landmark result = a_stays ? a : b;
  result.sightings = a.sightings + b.sightings;
  result.log_odds = std::min(a.log_odds + b.log_odds, static_cast<float>(settings.existence.log_odds_max));
  const Landmark& other = a_stays ? b : a;
  if (result.signature.empty()) {
    result.signature = other.signature;
    result.signature_views = other.signature_views;
  }
  result.last_seen = std::max(a.last_seen, b.last_seen);
  if (result.identity < 0) result.identity = std::max(a.identity, b.identity);
  return result;
}

}  // namespace

MergeCounts merge_neighbours(LandmarkStore& store, const FeatureMapSettings& settings,
                             std::span<const LandmarkRef> written) {
  MergeCounts counts;
  const int confirmed_from = settings.existence.min_observations;
  for (const LandmarkRef ref : written) {
    if (ref.chunk < 0) continue;
    const Partners partners = partners_of(store, settings, ref, written);
    for (std::size_t i = 0; i < partners.count; ++i) {
      const Landmark own = store.at(ref);
      const Landmark other = store.at(partners.refs[i]);
      const Landmark one = merged(own, other, settings);
      if (own.sightings < confirmed_from && other.sightings < confirmed_from && one.sightings >= confirmed_from)
        ++counts.confirmed;
      // The one that stays keeps its place, and with it its id.
      const bool own_stays = one.id == own.id;
      store.write(own_stays ? ref : partners.refs[i], one);
      store.erase(own_stays ? partners.refs[i] : ref);
      ++counts.merged;
      if (!own_stays) break;
    }
  }
  return counts;
}

}  // namespace waymark::feature_map
