// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;

constexpr const char* kHeader =
    "map,id,east_m,north_m,radius_m,var_east_m2,var_north_m2,cov_east_north_m2,var_radius_m2,existence,sightings,"
    "confirmed,conditional_var_east_m2,conditional_var_north_m2,conditional_cov_east_north_m2";

LandmarkView make_landmark(std::int64_t id, bool confirmed) {
  LandmarkView landmark;
  landmark.id = id;
  landmark.p_map = {1.5, -2.25};
  landmark.radius_m = 0.2;
  landmark.P << 0.01, 0.001, 0.0, 0.001, 0.04, 0.0, 0.0, 0.0, 0.0001;
  landmark.P_conditional << 0.0025, 0.0, 0.0, 0.0025;
  landmark.existence = 0.875;
  landmark.sightings = 12;
  landmark.confirmed = confirmed;
  return landmark;
}

FakeSnapshot& with_landmarks(FakeSnapshot& snapshot) {
  snapshot.maps_ = {{"trees", {make_landmark(3, true), make_landmark(4, false)}}};
  return snapshot;
}

TEST(LandmarksSink, WritesConfirmedLandmarks) {
  const TemporaryFolder out;
  const auto sink = make_sink("landmarks");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  sink->finish(&with_landmarks(snapshot), {});
  const auto lines = out.lines("landmarks.csv");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], kHeader);
  EXPECT_EQ(lines[1],
            "trees,3,1.500000,-2.250000,0.200000,1.000000e-02,4.000000e-02,1.000000e-03,1.000000e-04,0.875000,12,1,"
            "2.500000e-03,2.500000e-03,0.000000e+00");
}

TEST(LandmarksSink, WritesProvisionalLandmarksWhenAsked) {
  const TemporaryFolder out;
  const auto sink = make_sink("landmarks", "{ confirmed_only: false }");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  sink->finish(&with_landmarks(snapshot), {});
  const auto lines = out.lines("landmarks.csv");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[2].substr(0, 8), "trees,4,");
  EXPECT_NE(lines[2].find(",12,0,"), std::string::npos) << lines[2];
}

TEST(LandmarksSink, LeavesAnUnknownRadiusEmpty) {
  const TemporaryFolder out;
  const auto sink = make_sink("landmarks");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  with_landmarks(snapshot);
  snapshot.maps_[0].landmarks[0].radius_m = std::numeric_limits<double>::quiet_NaN();
  sink->finish(&snapshot, {});
  EXPECT_EQ(
      out.lines("landmarks.csv").at(1),
      "trees,3,1.500000,-2.250000,,1.000000e-02,4.000000e-02,1.000000e-03,,0.875000,12,1,2.500000e-03,2.500000e-03,"
      "0.000000e+00");
}

TEST(LandmarksSink, ARunWithoutMapsLeavesTheHeader) {
  const TemporaryFolder out;
  const auto sink = make_sink("landmarks");
  sink->start({out.path(), nullptr, nullptr});
  sink->finish(nullptr, {});
  EXPECT_EQ(out.lines("landmarks.csv"), std::vector<std::string>{kHeader});
  EXPECT_FALSE(out.has("reference_landmarks.csv"));
}

TEST(LandmarksSink, WritesTheReferenceLandmarks) {
  const TemporaryFolder out;
  auto reference = std::make_shared<Reference>();
  reference->landmarks = {{"c1", {1.0, 2.0}, 0.25},
                          {"north, \"old\" tree", {3.0, 4.0}, std::numeric_limits<double>::quiet_NaN()}};
  const auto sink = make_sink("landmarks");
  sink->start({out.path(), nullptr, reference});
  sink->finish(nullptr, {});
  const std::vector<std::string> expected{"name,x_m,y_m,radius_m", "c1,1.000000,2.000000,0.250000",
                                          "\"north, \"\"old\"\" tree\",3.000000,4.000000,"};
  EXPECT_EQ(out.lines("reference_landmarks.csv"), expected);
}

}  // namespace
}  // namespace waymark
