// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/landmark_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "temporary_folder.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::feature_map_test {
namespace {

using ::testing::HasSubstr;

class LandmarkFile : public ::testing::Test {
 protected:
  void write(const std::string& content) const { std::ofstream(file_) << content; }
  LandmarkStore read(const std::string& yaml = "{}") const { return read_landmark_file(file_, settings_of(yaml)); }
  /// Of a file with one landmark.
  Landmark read_one(const std::string& landmark, const std::string& yaml = "{}") const {
    write("version: 1\nlandmarks:\n  - " + landmark + "\n");
    return read(yaml).at({0, 0});
  }
  std::string message(const std::string& landmark, const std::string& yaml = "{}") const {
    try {
      read_one(landmark, yaml);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "trunks.landmarks.yaml";
};

Landmark landmark_at(double east, double north) {
  Landmark landmark;
  landmark.mean = {east, north, 0.31};
  landmark.P << 0.04, 0.01, 0.002, 0.01, 0.09, -0.003, 0.002, -0.003, 0.016;
  landmark.P_floor << 0.01, 0.002, 0.002, 0.02;
  landmark.log_odds = 3.25f;
  landmark.sightings = 17;
  return landmark;
}

TEST_F(LandmarkFile, WhatIsWrittenIsRead) {
  LandmarkStore store;
  for (int i = 0; i < 100; ++i) {  // more than one leaf
    Landmark landmark = landmark_at(1.5 * i, -0.1 * i);
    landmark.identity = i % 3 == 0 ? i : -1;
    if (i % 2 == 0) {
      landmark.signature = {0.25f, 0.625f, 0.125f};
      landmark.signature_views = i;
    }
    store.add(landmark);
  }
  write(landmark_file(store, Pose{}));
  const LandmarkStore again = read();
  ASSERT_EQ(again.size(), store.size());
  std::map<double, Landmark> by_east;
  again.for_all([&](const Landmark& landmark) { by_east[landmark.mean.x()] = landmark; });
  store.for_all([&](const Landmark& wanted) {
    ASSERT_TRUE(by_east.contains(wanted.mean.x()));
    const Landmark& is = by_east[wanted.mean.x()];
    EXPECT_EQ(is.mean, wanted.mean);
    EXPECT_EQ(is.P, wanted.P);
    EXPECT_EQ(is.P_floor, wanted.P_floor);
    EXPECT_EQ(is.log_odds, wanted.log_odds);
    EXPECT_EQ(is.sightings, wanted.sightings);
    EXPECT_EQ(is.identity, wanted.identity);
    EXPECT_EQ(is.signature_views, wanted.signature_views);
    EXPECT_TRUE(std::ranges::equal(is.signature, wanted.signature));
  });
}

TEST_F(LandmarkFile, AnEmptyMapIsAFileToo) {
  write(landmark_file({}, Pose{}));
  EXPECT_EQ(read().size(), 0u);
}

TEST_F(LandmarkFile, AMapThatLiesTurnedIsWrittenWhereItLies) {
  LandmarkStore store;
  store.add(landmark_at(2.0, 0.0));
  write(landmark_file(store, Pose::planar(10.0, 20.0, std::numbers::pi / 2)));
  const Landmark landmark = read().at({0, 0});
  EXPECT_NEAR(landmark.mean.x(), 10.0, 1e-12);
  EXPECT_NEAR(landmark.mean.y(), 22.0, 1e-12);
  EXPECT_NEAR(landmark.P(0, 0), 0.09, 1e-12);
  EXPECT_NEAR(landmark.P(1, 1), 0.04, 1e-12);
  EXPECT_NEAR(landmark.P(0, 2), 0.003, 1e-12);
  EXPECT_NEAR(landmark.P_floor(0, 0), 0.02, 1e-12);
}

TEST_F(LandmarkFile, ASurveyNeedsPlacesOnly) {
  const Landmark landmark = read_one("{ east_m: 3, north_m: -4 }", "{ existence: { min_observations: 5 } }");
  EXPECT_EQ(landmark.mean, Eigen::Vector3d(3.0, -4.0, 0.0));
  EXPECT_NEAR(landmark.P(0, 0), 1e-4, 1e-12);
  EXPECT_EQ(landmark.sightings, 5) << "confirmed from the start";
  EXPECT_EQ(landmark.log_odds, 5.0f);
  EXPECT_EQ(landmark.identity, -1);
}

TEST_F(LandmarkFile, ErrorsNameTheLineAndWhatIsWrong) {
  EXPECT_THAT(message("{ east_m: 3 }"), AllOf(HasSubstr("trunks.landmarks.yaml:3"), HasSubstr("north_m")));
  EXPECT_THAT(message("{ east_m: 3, north_m: .nan }"), AllOf(HasSubstr(":3"), HasSubstr("north_m")));
  EXPECT_THAT(message("{ east_m: 3, north_m: 4, radius: 0.1 }"), AllOf(HasSubstr("radius"), HasSubstr("radius_m")));
  EXPECT_THAT(message("{ east_m: 3, north_m: 4, covariance_m2: [1, 2, 1, 0, 0, 1] }"),
              HasSubstr("smallest eigenvalue is -1"));
  EXPECT_THAT(message("{ east_m: 3, north_m: 4, covariance_m2: [1, 2, 1] }"), HasSubstr("covariance_m2"));
  EXPECT_THAT(message("{ east_m: 3, north_m: 4, signature: [0.5, 0.4] }"), HasSubstr("add up to 0.9"));
  EXPECT_THAT(message("{ east_m: 3, north_m: 4, signature: [1.5, -0.5] }"), HasSubstr("bin 1 is -0.5"));
  EXPECT_THAT(
      message("{ east_m: 3, north_m: 4, signature: [0.5, 0.5] }", "{ identity: signature, signature: { bins: 4 } }"),
      HasSubstr("2 bins, but those of this configuration have 4"));
  EXPECT_THAT(message("{ east_m: 3, north_m: 4, signature: [0.5, 0.25, 0.25] }", "{ attributes: [signature] }"),
              HasSubstr("3 bins, but those of this configuration have 2"))
      << "reflectivity: dark and bright";
  EXPECT_THAT(
      message("{ east_m: 3, north_m: 4, signature: [0.5, 0.5] }\n  - { east_m: 5, north_m: 4, signature: [1] }"),
      HasSubstr("1 bins, but the landmarks before have 2"));
}

TEST_F(LandmarkFile, OtherVersionsAreRefused) {
  write("version: 2\nlandmarks: []\n");
  EXPECT_THROW(read(), ConfigError);
  write("landmarks: []\n");
  EXPECT_THROW(read(), ConfigError);
  write("P5\n4 3\n");
  EXPECT_THROW(read(), ConfigError);
}

/// Sees from (0, 0) the landmarks at (5, 0) and (4, 3), and something new at (6, -3).
FeatureObservation three_things() {
  FeatureObservation seen;
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(5, 0), Eigen::Vector2d(4, 3), Eigen::Vector2d(6, -3)})
    seen.detections.push_back(detection_of(p, Eigen::Vector3d::Zero()));
  seen.max_range = 20.0;
  return seen;
}

class LoadedLandmarks : public LandmarkFile {
 protected:
  LoadedLandmarks() { write("version: 1\nlandmarks:\n  - { east_m: 5, north_m: 0 }\n  - { east_m: 4, north_m: 3 }\n"); }

  /// A robot that believes to be at (0.1, 0) looks around.
  Refinement look(ParticleFeatureMap& map) const {
    const FeatureObservation seen = three_things();
    const PoseGaussian prior{Pose::planar(0.1, 0.0, 0.0), Eigen::Vector3d(0.04, 0.04, 0.001).asDiagonal()};
    Refinement refinement;
    map.refine(prior, prior.T_map_base, seen, refinement);
    map.insert(prior, seen, refinement.association.get());
    return refinement;
  }
  std::shared_ptr<const FeatureMapSettings> settings(const std::string& mode) const {
    return std::make_shared<FeatureMapSettings>(settings_of("{ load: /x.yaml, mode: " + mode + " }"));
  }
};

TEST_F(LoadedLandmarks, LocalizingMovesThePoseAndLeavesTheMap) {
  ParticleFeatureMap map(settings("localize"), read());
  const std::string before = landmark_file(map.landmarks(), Pose{});
  const Refinement refinement = look(map);
  EXPECT_FALSE(refinement.writes);
  const Eigen::Matrix3d P = Eigen::Vector3d(0.04, 0.04, 0.001).asDiagonal();
  const Eigen::Vector3d moved =
      (Eigen::Matrix3d::Identity() + P * refinement.information).inverse() * P * refinement.gradient;
  EXPECT_NEAR(moved.x(), -0.1, 0.03);
  EXPECT_EQ(landmark_file(map.landmarks(), Pose{}), before);
}

TEST_F(LoadedLandmarks, ContinuingAddsWhatIsNew) {
  ParticleFeatureMap map(settings("continue"), read());
  EXPECT_TRUE(look(map).writes);
  EXPECT_EQ(map.landmarks().size(), 3u);
}

}  // namespace
}  // namespace waymark::feature_map_test
