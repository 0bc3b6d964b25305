// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/landmark_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "plugins/shared/map_formats/landmark_list.hpp"
#include "waymark/base/error.hpp"

namespace waymark::feature_map {

namespace {

static_assert(map_formats::LandmarkEntry::kMaxBins <= Signature::kMaxBins);

Landmark landmark_of(const map_formats::LandmarkEntry& entry, const FeatureMapSettings& settings) {
  Landmark landmark;
  landmark.mean = entry.mean;
  landmark.P = entry.P;
  landmark.P_floor = entry.P_floor;
  if (!entry.signature.empty()) landmark.signature = Signature::uniform(entry.signature.size());
  std::ranges::copy(entry.signature, landmark.signature.begin());
  landmark.signature_views = entry.signature_views;
  landmark.identity = entry.identity;
  landmark.log_odds = entry.log_odds.value_or(static_cast<float>(settings.existence.log_odds_max));
  landmark.sightings = entry.sightings.value_or(settings.existence.min_observations);
  return landmark;
}

}  // namespace

std::string landmark_file(const LandmarkStore& landmarks, const Pose& T_enu_map) {
  std::string text = fmt::format(
      "# Landmarks of a feature map (waymark); covariances of east, north, radius: ee, en, nn, er, nr, rr.\n"
      "version: {}\nlandmarks:{}\n",
      map_formats::kLandmarkListVersion, landmarks.size() == 0 ? " []" : "");
  auto out = std::back_inserter(text);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_enu_map.q.toRotationMatrix().topLeftCorner<2, 2>();
  landmarks.for_all([&](const Landmark& landmark) {
    const Eigen::Vector3d p = T_enu_map * Eigen::Vector3d(landmark.mean.x(), landmark.mean.y(), 0.0);
    const Eigen::Matrix3d P = turn * landmark.P * turn.transpose();
    const Eigen::Matrix2d floor =
        turn.topLeftCorner<2, 2>() * landmark.P_floor * turn.topLeftCorner<2, 2>().transpose();
    fmt::format_to(out,
                   "  - {{ east_m: {}, north_m: {}, radius_m: {}, covariance_m2: [{}, {}, {}, {}, {}, {}], "
                   "covariance_floor_m2: [{}, {}, {}], log_odds: {}, sightings: {}",
                   p.x(), p.y(), landmark.mean.z(), P(0, 0), P(0, 1), P(1, 1), P(0, 2), P(1, 2), P(2, 2), floor(0, 0),
                   floor(0, 1), floor(1, 1), landmark.log_odds, landmark.sightings);
    if (landmark.identity >= 0) fmt::format_to(out, ", identity: {}", landmark.identity);
    if (!landmark.signature.empty()) {
      fmt::format_to(out, ", signature_views: {}, signature: [{}]", landmark.signature_views,
                     fmt::join(landmark.signature, ", "));
    }
    fmt::format_to(out, " }}\n");
  });
  return text;
}

LandmarkStore read_landmark_file(const std::filesystem::path& file, const FeatureMapSettings& settings) {
  LandmarkStore landmarks;
  const std::size_t expected = settings.signature_bins();
  for (const map_formats::LandmarkEntry& entry : map_formats::read_landmark_list(file)) {
    const std::size_t bins = entry.signature.size();
    if (expected != 0 && bins != 0 && bins != expected) {
      throw ConfigError(
          fmt::format("{}: signature: {} bins, but those of this configuration have {}", entry.place, bins, expected));
    }
    landmarks.add(landmark_of(entry, settings));
  }
  return landmarks;
}

}  // namespace waymark::feature_map
