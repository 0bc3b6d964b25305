// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// What the clouds source delivers. Bad files: clouds_errors_test.cpp.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "unit/plugins/sources/clouds/clouds_fixture.hpp"
#include "unit/plugins/sources/csv/csv_fixture.hpp"
#include "waymark/base/time.hpp"

namespace waymark::clouds_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<int> millimetres(const Measurement& m) {
  std::vector<int> x;
  for (const Eigen::Vector3f& p : m.as<PointCloud>().points_m)
    x.push_back(static_cast<int>(std::lround(1000.0f * p.x())));
  return x;
}

TEST_F(CloudsTest, PointsOfACompactFileAreInUnitsOfTwoMillimetres) {
  write(compact_head(2) + compact_cloud(10.0, {{500, -250, 1}, {-32768, 32767, 0}}) + compact_cloud(10.5, {{1, 2, 3}}));
  const auto source = make();
  ASSERT_EQ(source->channels().size(), 1U);
  EXPECT_EQ(source->channels()[0].sensor, "lidar");
  EXPECT_EQ(source->channels()[0].payload_type, "waymark/PointCloud@1");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 2U);
  const auto& cloud = all[0].as<PointCloud>();
  ASSERT_EQ(cloud.points_m.size(), 2U);
  EXPECT_TRUE(cloud.points_m[0].isApprox(Eigen::Vector3f(1.0f, -0.5f, 0.002f)));
  EXPECT_TRUE(cloud.points_m[1].isApprox(Eigen::Vector3f(-65.536f, 65.534f, 0.0f)));
  EXPECT_THAT(cloud.intensities, IsEmpty());
  EXPECT_THAT(cloud.offsets_s, IsEmpty());
  EXPECT_EQ(all[1].stamp, parse_time("10.5"));
  EXPECT_EQ(all[1].arrival, all[1].stamp);
  EXPECT_EQ(all[1].sequence, 1U);
  EXPECT_EQ(source->progress(), 1.0);
}

TEST_F(CloudsTest, AStampIsTheDecimalNumberThatItsFloatStandsFor) {
  // The double nearest to this is 1630577758.5694899559…
  write(compact_head(1) + compact_cloud(1630577758.56949, row_of(1)));
  EXPECT_EQ(read_all(*make()).at(0).stamp, parse_time("1630577758.569490000"));
}

TEST_F(CloudsTest, AFullFileHasIntensitiesAndTimesAsItSays) {
  const std::int64_t t = 1'630'577'758'569'490'123;
  const float inf = std::numeric_limits<float>::infinity();
  write(full_head(1, 3) + full_cloud(t, 2, {1.5f, -2.5f, 1e4f, 7.0f, 0.01f, 4.0f, 5.0f, 6.0f, inf, -0.02f}));
  const auto all = read_all(*make());
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].stamp.time_since_epoch().count(), t);
  const auto& cloud = all[0].as<PointCloud>();
  EXPECT_THAT(cloud.points_m, ElementsAre(Eigen::Vector3f(1.5f, -2.5f, 1e4f), Eigen::Vector3f(4.0f, 5.0f, 6.0f)));
  EXPECT_THAT(cloud.offsets_s, ElementsAre(0.01f, -0.02f));
  ASSERT_EQ(cloud.intensities.size(), 2U);
  EXPECT_EQ(cloud.intensities[0], 7.0f);
  EXPECT_TRUE(std::isnan(cloud.intensities[1]));

  write(full_head(1, 2) + full_cloud(5, 1, {1.0f, 2.0f, 3.0f, 0.5f}));
  const auto timed = read_all(*make());
  EXPECT_THAT(timed.at(0).as<PointCloud>().offsets_s, ElementsAre(0.5f));
  EXPECT_THAT(timed.at(0).as<PointCloud>().intensities, IsEmpty());
}

TEST_F(CloudsTest, GzipAndPlainFilesGiveTheSame) {
  // 40 000 points: more than one piece of the reader's.
  const std::string bytes = compact_head(2) + compact_cloud(1.0, row_of(32767)) + compact_cloud(2.0, row_of(7));
  write(bytes);
  write(csv_test::gzip(bytes, 1000), "packed.bin");
  const auto plain = read_all(*make());
  const auto packed = read_all(*make("", "packed.bin"));
  ASSERT_EQ(plain.size(), 2U);
  ASSERT_EQ(packed.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(plain[i].as<PointCloud>().points_m, packed[i].as<PointCloud>().points_m);
    EXPECT_EQ(plain[i].stamp, packed[i].stamp);
  }
  EXPECT_EQ(plain[0].as<PointCloud>().points_m.size(), 32767U);
}

TEST_F(CloudsTest, ThinningTakesEveryNthPointAndOfThoseAtMostSoMany) {
  write(compact_head(2) + compact_cloud(1.0, row_of(10)) + compact_cloud(2.0, row_of(3)));
  auto all = read_all(*make("every_nth_point: 3"));
  EXPECT_THAT(millimetres(all.at(0)), ElementsAre(0, 6, 12, 18));
  EXPECT_THAT(millimetres(all.at(1)), ElementsAre(0));
  all = read_all(*make("max_points: 4"));
  EXPECT_THAT(millimetres(all.at(0)), ElementsAre(0, 6, 10, 16));
  EXPECT_THAT(millimetres(all.at(1)), ElementsAre(0, 2, 4));
  all = read_all(*make("every_nth_point: 2, max_points: 2"));
  EXPECT_THAT(millimetres(all.at(0)), ElementsAre(0, 12));
  EXPECT_THAT(millimetres(all.at(1)), ElementsAre(0, 4));
}

TEST_F(CloudsTest, ThinningTakesTheTimesOfItsPoints) {
  write(full_head(1, 2) + full_cloud(5, 3, {1, 0, 0, 0.25f, 2, 0, 0, 0.5f, 3, 0, 0, 0.75f}));
  const auto all = read_all(*make("every_nth_point: 2"));
  EXPECT_THAT(all.at(0).as<PointCloud>().offsets_s, ElementsAre(0.25f, 0.75f));
}

TEST_F(CloudsTest, ARangeOfCloudsIsByNumberOrByTime) {
  std::string bytes = compact_head(6);
  for (int k = 0; k < 6; ++k) bytes += compact_cloud(100.0 + 0.5 * k, row_of(static_cast<std::int16_t>(k)));
  write(bytes);
  const auto sizes = [this](const std::string& keys) {
    std::vector<std::size_t> counts;
    for (const Measurement& m : read_all(*make(keys))) counts.push_back(m.as<PointCloud>().points_m.size());
    return counts;
  };
  EXPECT_THAT(sizes("first_cloud: 1, last_cloud: 3"), ElementsAre(1, 2, 3));
  EXPECT_THAT(sizes("start_s: 0.5, end_s: 1.9"), ElementsAre(1, 2, 3));
  // Times count from the file's first cloud, wherever the range begins.
  EXPECT_THAT(sizes("first_cloud: 2, end_s: 1.5"), ElementsAre(2, 3));
  EXPECT_THAT(sizes("last_cloud: 0"), ElementsAre(0));
  EXPECT_THAT(sizes("start_s: 60"), IsEmpty());
}

TEST(CloudsRecording, TheHallHasAllItsPoints) {
  const char* data = std::getenv("WAYMARK_DATA");
  if (data == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const std::string yaml = "{ file: " + std::string(data) + "/hilti_os0_hall/scans.bin.gz, sensor: lidar }";
  const auto source =
      PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("clouds", Config::parse(yaml), Rig({{"lidar", "", Pose{}}}));
  std::size_t points = 0;
  std::vector<Time> stamps;
  float farthest = 0.0f;
  while (const auto m = source->next()) {
    stamps.push_back(m->stamp);
    for (const Eigen::Vector3f& p : m->as<PointCloud>().points_m)
      farthest = std::max(farthest, p.cwiseAbs().maxCoeff());
    points += m->as<PointCloud>().points_m.size();
  }
  // Its README: 4 699 573 points in 120 scans of 59.5 s; poses.csv has these stamps.
  EXPECT_EQ(points, 4'699'573U);
  ASSERT_EQ(stamps.size(), 120U);
  EXPECT_EQ(stamps[0], parse_time("1630577758.569490"));
  EXPECT_EQ(stamps[1], parse_time("1630577759.068947"));
  EXPECT_NEAR(to_seconds(stamps.back() - stamps.front()), 59.5, 0.05);
  EXPECT_LE(farthest, 65.536f);
}

}  // namespace
}  // namespace waymark::clouds_test
