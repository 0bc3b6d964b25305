// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, diagnostics, dgps, feature_map, geo_track, held_out, landmarks, odometry, tum
// `waymark evaluate` on the output folders of runs, and what other programs read of them.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The small robot with geodetic fixes, of which every second one is held out, and no map.
class GeodeticRobot : public SmallRobot {
 public:
  GeodeticRobot() {
    fixes = {"t_s,lat,lon"};
    for (int i = 0; i < static_cast<int>(kDuration); ++i) {
      const double t = i + 0.25;
      fixes.push_back(fmt::format("{:.3f},{:.9f},{:.9f}", t, 49.0, 8.4 + kSpeed * t / 73171.77));
    }
    replace("columns: { east_m: east_m, north_m: north_m }", "columns: { latitude_deg: lat, longitude_deg: lon }");
    replace("sigma_m: 0.3\n", "sigma_m: 0.3\n    fuse: alternate\n    fuse_on_s: 1\n    fuse_off_s: 1\n");
    replace("  - { plugin: landmarks }\n", "  - { plugin: held_out }\n  - { plugin: geo_track }\n");
  }
};

TEST(EvaluateRun, FindsFixesThatWereHeldOutWithTheirDatum) {
  GeodeticRobot robot;
  const Outcome ran = robot.run();
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const Outcome outcome = waymark({"evaluate", robot.out().string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("trajectory.txt, held_out.csv, diagnostics.json\n"));
  EXPECT_THAT(outcome.out, HasSubstr("position error (plane)"));
  EXPECT_THAT(outcome.out, HasSubstr("NIS, mean over a sensor's updates"));
}

TEST(EvaluateRun, IsTheSameAsWithThePaths) {
  SmallRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::string path = (robot.out() / "path.txt").string();
  const Outcome found = waymark({"evaluate", robot.out().string(), "--reference", path, "--json"});
  const Outcome given = waymark({"evaluate", "--estimate", (robot.out() / "trajectory.txt").string(), "--reference",
                                 path, "--covariance", (robot.out() / "covariance.csv").string(), "--diagnostics",
                                 (robot.out() / "diagnostics.json").string(), "--json"});
  EXPECT_EQ(given.exit_code, 0) << given.err;
  EXPECT_EQ(found.out, given.out);
}

TEST(EvaluateRun, OfSeveralRunsIsATableAndAPicture) {
  SmallRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::string first = robot.out().string();
  const std::string second = robot.file("second").string();
  ASSERT_EQ(waymark({"run", robot.file("robot.yaml").string(), "--seed", "2", "--out", second}).exit_code, 0);
  const std::string picture = robot.file("both.svg").string();
  const std::vector<std::string> call{"evaluate",          first,       second, "--reference",
                                      first + "/path.txt", "--overlay", picture};
  const Outcome outcome = waymark(call);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::vector<std::string> lines = lines_of(outcome.out);
  ASSERT_EQ(lines.size(), 3u) << outcome.out;
  EXPECT_THAT(lines[0], HasSubstr("plane rms [m]"));
  EXPECT_TRUE(lines[1].starts_with(first));
  EXPECT_TRUE(lines[2].starts_with(second));
  EXPECT_THAT(read_text(picture), HasSubstr(second + "</text>"));
  std::vector<std::string> as_json = call;
  as_json.emplace_back("--json");
  EXPECT_EQ(nlohmann::json::parse(waymark(as_json).out).at("runs").at(1).at("run"), second);
}

TEST(EvaluateRun, OfAFolderWithoutARunIsOneErrorLine) {
  const TemporaryFolder folder;
  EXPECT_TRUE(reports_error(waymark({"evaluate", folder.path().string()}), 1, {"has no trajectory.txt", "sink tum"}));
}

TEST(GeoTrack, IsReadByOgrinfo) {
  if (std::system("command -v ogrinfo > /dev/null") != 0) GTEST_SKIP() << "ogrinfo is not installed (Debian: gdal-bin)";
  GeodeticRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::string report = robot.file("report").string();
  for (const char* name : {"track.gpx", "track.kml", "track.geojson"}) {
    const std::string call = fmt::format("ogrinfo -ro -al '{}' > '{}' 2>&1", (robot.out() / name).string(), report);
    EXPECT_EQ(std::system(call.c_str()), 0) << read_text(report);
    EXPECT_THAT(read_text(report), HasSubstr("successful"));
    EXPECT_THAT(read_text(report), HasSubstr("LINESTRING")) << name;
    EXPECT_THAT(read_text(report), Not(HasSubstr("ERROR"))) << name;
  }
}

}  // namespace
}  // namespace waymark::system_test
