// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/trajectory_io.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string_view>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

class TrajectoryIo : public ::testing::Test {
 protected:
  std::filesystem::path file(std::string_view content, std::string_view name = "data.txt") const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  template <class Call>
  static std::string message_of(Call call) {
    try {
      call();
    } catch (const Error& error) {
      return error.what();
    }
    return "nothing was thrown";
  }

  test::TemporaryFolder folder_;
};

// gzip of "t,x,y\n1.5,2,3\n".
constexpr unsigned char kGzipped[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0x2b, 0xd1,
                                      0xa9, 0xd0, 0xa9, 0xe4, 0x32, 0xd4, 0x33, 0xd5, 0x31, 0xd2, 0x31, 0xe6,
                                      0x02, 0x00, 0xf8, 0x3f, 0xa6, 0xc3, 0x0e, 0x00, 0x00, 0x00};

TEST_F(TrajectoryIo, GeodeticPositionsNeedADatum) {
  const auto held_out = file(
      "t_s,sensor,x_m,y_m,z_m,latitude_deg,longitude_deg,height_m\n"
      "1,gps,,,,49.001,8.001,110\n2,other,3,4,,,,\n");
  const Trajectory t = read_trajectory(held_out, std::nullopt, Datum{49.0, 8.0, 100.0});
  ASSERT_EQ(t.points.size(), 2u);
  EXPECT_NEAR(t.points[0].pose.p.x(), 73.17, 0.01);
  EXPECT_NEAR(t.points[0].pose.p.y(), 111.21, 0.01);
  EXPECT_EQ(t.points[1].pose.p.head<2>(), Eigen::Vector2d(3.0, 4.0));
  EXPECT_FALSE(t.has_z) << "one row has no height";
  EXPECT_THAT(message_of([&] { read_trajectory(held_out); }),
              ::testing::HasSubstr("data.txt:2: the positions are geodetic"));
  const auto heights = file("t,latitude_deg,longitude_deg,height_m\n1,49,8,110\n");
  EXPECT_NEAR(read_trajectory(heights, std::nullopt, Datum{49.0, 8.0, 100.0}).points[0].pose.p.z(), 10.0, 1e-6);
}

TEST_F(TrajectoryIo, APlaceThatIsNotOnTheEarthIsRefused) {
  for (const std::string place : {"4001,8,1", "91,8,1"}) {
    const auto places = file("t,latitude_deg,longitude_deg,height_m\n1,49,8,110\n2," + place + "\n");
    EXPECT_THAT(message_of([&] {
                  read_trajectory(places, std::nullopt, Datum{49.0, 8.0, 100.0});
                }),
                ::testing::HasSubstr("data.txt:3: latitude"))
        << place;
  }
}

TEST_F(TrajectoryIo, ReadsTum) {
  const Trajectory t = read_trajectory(file("# comment\n1.000000001 2 3 4 0 0 0.6 0.8\n\n2 5 6 7 0 0 0 1\n"));
  ASSERT_EQ(t.points.size(), 2u);
  EXPECT_EQ(t.points[0].stamp, Time(Duration(1000000001)));
  EXPECT_EQ(t.points[0].pose.p, Eigen::Vector3d(2, 3, 4));
  EXPECT_NEAR(t.points[0].pose.yaw(), 2.0 * std::atan2(0.6, 0.8), 1e-12);
  EXPECT_TRUE(t.has_z);
  EXPECT_EQ(t.orientation, Orientation::full);
}

TEST_F(TrajectoryIo, WithoutAHeightOnlyTheYawOfAQuaternionCounts) {
  const Trajectory t = read_trajectory(file("1 2 3 nan 0 0 0.6 0.8\n2 5 6 nan 0 0 0 1\n"));
  EXPECT_FALSE(t.has_z);
  EXPECT_EQ(t.orientation, Orientation::yaw);
  EXPECT_EQ(t.points[0].pose.p, Eigen::Vector3d(2, 3, 0));
}

TEST_F(TrajectoryIo, TakesIdentityEverywhereAsNoOrientation) {
  const Trajectory t = read_trajectory(file("1 2 3 4 0 0 0 1\n2 5 6 7 0 0 0 1\n"));
  EXPECT_EQ(t.orientation, Orientation::none);
}

TEST_F(TrajectoryIo, ReadsHeldOutFixesByTheirNames) {
  const Trajectory t = read_trajectory(
      file("t_s,sensor,x_m,y_m,z_m,latitude_deg,longitude_deg,height_m\n1.5,gps,1,2,,,,\n2.5,gps,3,4,5,,,\n"));
  ASSERT_EQ(t.points.size(), 2u);
  EXPECT_EQ(t.points[1].pose.p, Eigen::Vector3d(3, 4, 0));
  EXPECT_FALSE(t.has_z) << "one row has no height";
  EXPECT_EQ(t.orientation, Orientation::none);
}

TEST_F(TrajectoryIo, ReadsYawByName) {
  const Trajectory t = read_trajectory(file("time east_m north_m yaw_rad\n1 2 3 0.5\n"));
  EXPECT_EQ(t.orientation, Orientation::yaw);
  EXPECT_NEAR(t.points[0].pose.yaw(), 0.5, 1e-12);
}

TEST_F(TrajectoryIo, ReadsGivenColumns) {
  const auto columns = parse_columns("t=3,x=1,y=0", trajectory_quantities());
  const Trajectory t = read_trajectory(file("10 20 30 1\n11 21 31 2\n"), columns);
  EXPECT_EQ(t.points[1].stamp, Time(from_seconds(2)));
  EXPECT_EQ(t.points[1].pose.p, Eigen::Vector3d(21, 11, 0));
}

TEST_F(TrajectoryIo, ReadsCompressedFiles) {
  const Trajectory t = read_trajectory(file({reinterpret_cast<const char*>(kGzipped), sizeof kGzipped}, "data.csv.gz"));
  ASSERT_EQ(t.points.size(), 1u);
  EXPECT_EQ(t.points[0].pose.p, Eigen::Vector3d(2, 3, 0));
}

TEST_F(TrajectoryIo, RefusesACompressedFileThatEndsEarly) {
  const auto half = file({reinterpret_cast<const char*>(kGzipped), 20}, "data.csv.gz");
  EXPECT_THROW(read_trajectory(half), DataError);
}

TEST_F(TrajectoryIo, SortsByStampAndKeepsTheLastOfEqualStamps) {
  const Trajectory t = read_trajectory(file("t,x,y\n2,20,0\n1,10,0\n2,21,0\n"));
  ASSERT_EQ(t.points.size(), 2u);
  EXPECT_EQ(t.points[0].pose.p.x(), 10.0);
  EXPECT_EQ(t.points[1].pose.p.x(), 21.0);
}

TEST_F(TrajectoryIo, NamesTheLineOfABadNumber) {
  const auto bad = file("t,x,y\n1,2,3\n2,abc,3\n");
  EXPECT_THAT(message_of([&] { read_trajectory(bad); }),
              ::testing::AllOf(::testing::HasSubstr("data.txt:3"), ::testing::HasSubstr("\"abc\"")));
}

TEST_F(TrajectoryIo, NamesTheLineOfAShortRow) {
  const auto bad = file("t,x,y\n1,2\n");
  EXPECT_THAT(message_of([&] { read_trajectory(bad); }), ::testing::HasSubstr("data.txt:2"));
}

TEST_F(TrajectoryIo, RefusesAnUnnormalisedQuaternion) {
  EXPECT_THROW(read_trajectory(file("1 2 3 4 0 0 0 2\n")), DataError);
}

TEST_F(TrajectoryIo, SaysWhichColumnIsMissing) {
  const auto bad = file("t,x,height\n1,2,3\n");
  EXPECT_THAT(message_of([&] { read_trajectory(bad); }), ::testing::HasSubstr("no column for y"));
}

TEST_F(TrajectoryIo, RefusesMissingAndEmptyFiles) {
  EXPECT_THROW(read_trajectory(folder_ / "absent.txt"), DataError);
  EXPECT_THROW(read_trajectory(file("# nothing\n")), DataError);
}

TEST_F(TrajectoryIo, RefusesColumnsThatMakeNoSense) {
  EXPECT_THROW(parse_columns("t=0,t=1", trajectory_quantities()), Error);
  EXPECT_THROW(parse_columns("t=-1", trajectory_quantities()), Error);
  EXPECT_THROW(parse_columns("t", trajectory_quantities()), Error);
  EXPECT_THROW(parse_columns("speed=1", trajectory_quantities()), Error);
}

TEST_F(TrajectoryIo, ReadsTheLandmarksOfAMap) {
  const auto landmarks = read_landmarks(file(
      "map,id,east_m,north_m,radius_m,var_east_m2,var_north_m2,cov_east_north_m2,var_radius_m2,existence,sightings,"
      "confirmed\ntrees,7,1.5,-2,0.25,0.1,0.1,0,0.01,0.99,42,1\ntrees,8,3,4,nan,0.1,0.1,0,0,0.9,3,0\n"));
  ASSERT_EQ(landmarks.size(), 2u);
  EXPECT_EQ(landmarks[0].name, "7");
  EXPECT_EQ(landmarks[0].p_map, Eigen::Vector2d(1.5, -2));
  EXPECT_EQ(landmarks[0].radius_m, 0.25);
  EXPECT_EQ(landmarks[0].sightings, 42);
  EXPECT_TRUE(std::isnan(landmarks[1].radius_m));
}

TEST_F(TrajectoryIo, RefusesSightingsThatAreNoCount) {
  for (const char* sightings : {"1e300", "-1", "nan"})
    EXPECT_THROW(read_landmarks(file("id,x_m,y_m,sightings\nA1,1,2," + std::string(sightings) + "\n")), DataError);
}

TEST_F(TrajectoryIo, ReadsASurveyWithoutRadii) {
  const auto survey = read_landmarks(file("id,x_m,y_m\nA1,1,2\n"));
  ASSERT_EQ(survey.size(), 1u);
  EXPECT_EQ(survey[0].name, "A1");
  EXPECT_TRUE(std::isnan(survey[0].radius_m));
}

}  // namespace
}  // namespace waymark::evaluation
