// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/merging.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::detection_of;
using feature_map_test::landmark_at;
using feature_map_test::observation_of;
using feature_map_test::settings_of;

const std::string kYaml =
    "{ negative_information: false, association: { merge: true, min_separation_m: 0.5 },"
    " existence: { min_observations: 3, log_odds_max: 5 } }";

std::vector<Landmark> content(const LandmarkStore& store) {
  std::vector<Landmark> all;
  store.for_all([&](const Landmark& landmark) { all.push_back(landmark); });
  return all;
}

LandmarkRef ref_of(const LandmarkStore& store, std::int64_t id) {
  LandmarkRef found;
  store.for_near({0.0, 0.0}, 1e6, [&](LandmarkRef ref, StoredLandmark landmark) {
    if (landmark.id() == id) found = ref;
  });
  return found;
}

/// A well known landmark, and a worse known one `gap` away.
struct Pair {
  LandmarkStore store;
  Landmark good = landmark_at(5.0, 0.0, 0.05);
  Landmark bad;

  explicit Pair(double gap) : bad(landmark_at(5.0 + gap, 0.0, 0.2)) {
    bad.sightings = 4;
    bad.log_odds = 1.0f;
  }
  MergeCounts merge(std::vector<std::int64_t> written, const std::string& yaml = kYaml) {
    good.id = store.add(good);
    bad.id = store.add(bad);
    std::vector<LandmarkRef> refs;
    for (const std::int64_t id : written) refs.push_back(ref_of(store, id));
    return merge_neighbours(store, settings_of(yaml), refs);
  }
};

TEST(Merging, TheBetterKnownOneStaysWithTheSightingsOfBoth) {
  for (const std::int64_t written : {0, 1}) {
    Pair pair(0.3);
    EXPECT_EQ(pair.merge({written}).merged, 1);
    const auto left = content(pair.store);
    ASSERT_EQ(left.size(), 1u);
    EXPECT_EQ(left[0].id, pair.good.id);
    EXPECT_EQ(left[0].mean, pair.good.mean);
    EXPECT_EQ(left[0].P, pair.good.P);  // no information is counted twice
    EXPECT_EQ(left[0].sightings, 14);
    EXPECT_EQ(left[0].log_odds, 4.0f);
  }
}

TEST(Merging, LogOddsStayBelowTheirMaximum) {
  Pair pair(0.3);
  pair.bad.log_odds = 4.5f;
  pair.merge({0});
  EXPECT_EQ(content(pair.store)[0].log_odds, 5.0f);
}

TEST(Merging, FartherThanTheSeparationTheyAreTwo) { EXPECT_EQ(Pair(0.55).merge({0}).merged, 0); }

TEST(Merging, WhatDisagreesIsTwo) {
  Pair pair(0.4);
  pair.bad.P = pair.good.P;  // 0.4 m at 0.07 m
  EXPECT_EQ(pair.merge({0}).merged, 0);
}

TEST(Merging, RadiiThatDisagreeAreTwo) {
  const std::string with_radius = "{ attributes: [radius]," + kYaml.substr(1);
  Pair alike(0.2);
  EXPECT_EQ(alike.merge({0}, with_radius).merged, 1);
  Pair pair(0.2);
  pair.bad.mean.z() = 1.2;  // against 0.2 m at 0.2 m
  EXPECT_EQ(pair.merge({0}, with_radius).merged, 0);
}

TEST(Merging, OnlyAroundWhatWasWritten) { EXPECT_EQ(Pair(0.2).merge({}).merged, 0); }

TEST(Merging, TwoThatWereSeenAtOnceAreTwo) { EXPECT_EQ(Pair(0.2).merge({0, 1}).merged, 0); }

TEST(Merging, DifferentIdentitiesNeverMerge) {
  Pair different(0.1);
  different.good.identity = 3;
  different.bad.identity = 4;
  EXPECT_EQ(different.merge({0}).merged, 0);
  Pair unknown(0.1);
  unknown.bad.identity = 4;
  EXPECT_EQ(unknown.merge({0}).merged, 1);
  EXPECT_EQ(content(unknown.store)[0].identity, 4);
}

TEST(Merging, TwoProvisionalOnesMayMakeAConfirmedOne) {
  Pair pair(0.1);
  pair.good.sightings = 2;
  pair.bad.sightings = 1;
  EXPECT_EQ(pair.merge({0}).confirmed, 1);
}

/// What a map with two such landmarks shows after one look at the good one.
MapDescription after_a_look(const std::string& yaml) {
  Pair pair(0.3);
  pair.store.add(pair.good);
  pair.store.add(pair.bad);
  std::stringstream stream;
  OutArchive out(stream);
  out.section("feature_map", 1);  // the version without figures
  out.value(0.5);
  out.value(1.0);
  pair.store.save(out);
  InArchive in(stream);
  ParticleFeatureMap map(std::make_shared<FeatureMapSettings>(settings_of(yaml)));
  map.load(in);
  const Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  feature_map_test::step(map, pose, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(),
                         observation_of({detection_of({5.0, 0.0}, pose)}));
  MapDescription description;
  map.describe(description);
  return description;
}

TEST(Merging, IsSwitchedByTheConfiguration) {
  const MapDescription with = after_a_look("{ negative_information: false, association: { merge: true } }");
  const MapDescription without = after_a_look("{ negative_information: false, association: { merge: false } }");
  EXPECT_EQ(without.landmarks.size(), 2u);
  ASSERT_EQ(with.landmarks.size(), 1u);
  EXPECT_EQ(with.landmarks[0].sightings, 10 + 4 + 1);
  EXPECT_EQ(with.figures[2].name, "merged");
  EXPECT_EQ(with.figures[2].value, 1.0);
}

}  // namespace
}  // namespace waymark::feature_map
