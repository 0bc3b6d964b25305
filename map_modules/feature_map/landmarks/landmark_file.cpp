// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/landmark_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

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
  std::vector<map_formats::LandmarkEntry> entries;
  entries.reserve(static_cast<std::size_t>(landmarks.size()));
  landmarks.for_all([&](const Landmark& landmark) {
    map_formats::LandmarkEntry& entry = entries.emplace_back();
    entry.mean = landmark.mean;
    entry.P = landmark.P;
    entry.P_floor = landmark.P_floor;
    entry.signature.assign(landmark.signature.begin(), landmark.signature.end());
    entry.signature_views = landmark.signature_views;
    entry.identity = landmark.identity;
    entry.log_odds = landmark.log_odds;
    entry.sightings = landmark.sightings;
    map_formats::move_landmark(T_enu_map, entry);
  });
  return map_formats::landmark_list_text(entries);
}

LandmarkStore read_landmark_file(const std::filesystem::path& file, const FeatureMapSettings& settings) {
  LandmarkStore landmarks;
  const std::size_t expected = settings.signature_bins();
  for (map_formats::LandmarkEntry& entry : map_formats::read_landmark_list(file)) {
    const std::size_t bins = entry.signature.size();
    if (expected != 0 && bins != 0 && bins != expected) {
      throw ConfigError(
          fmt::format("{}: signature: {} bins, but those of this configuration have {}", entry.place, bins, expected));
    }
    map_formats::move_landmark(settings.load.T_map_file, entry);
    landmarks.add(landmark_of(entry, settings));
  }
  return landmarks;
}

}  // namespace waymark::feature_map
