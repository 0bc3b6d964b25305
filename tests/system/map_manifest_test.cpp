// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, feature_map, map_files, occupancy_grid, octomap_grid, odometry, simulator, tum
// The maps of a run with GPS as one map on disk: a robot whose own frame lies turned and shifted on the Earth writes
// landmarks, a grid and an octree; another run finds itself by each of them and by all, in the same frame.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kRobot = R"(source:
  plugin: simulator
  seed: 1
  duration_s: 60
  speed_mps: 1.0
  course: { waypoints_m: [0, 0, 14, 0, 14, 9, 0, 9], laps: 1 }
  walls_m: [-6, -6, 20, -6,  20, -6, 20, 15,  20, 15, -6, 15,  -6, 15, -6, -6,  5, 3, 8, 6,  8, 6, 9, 3,  9, 3, 5, 3]
  landmarks: { count: 14, area_m: [-4, -4, 18, 13], radius_m: [0.1, 0.3], min_distance_m: 3, course_clearance_m: 1.2, seed: 7 }
  wheels: { sensor: wheels, rate_hz: 40, track_m: 0.5, noise_m_per_sqrt_s: 0.005 }
  gps: { sensor: gps, rate_hz: 5, sigma_m: 0.3, base_p_antenna_m: [0.1, 0, 0.5] }
  lidar: { sensor: lidar, rate_hz: 5, range_max_m: 15, start_deg: -135, step_deg: 1.0, beams: 271, sigma_m: 0.02 }
motion: { kind: planar }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5, speed_noise_m_per_sqrt_s: [0.005, 0.01],
      lateral_noise_m_per_sqrt_s: [0, 0.02], yaw_noise_rad_per_sqrt_s: [0.015, 0.01, 0.05] }
  - { name: gps, plugin: dgps, sigma_m: 0.3, base_p_antenna_m: [0.1, 0, 0.5] }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0.2, 0, 0.3], yaw_deg: 0 } }
maps:
  - name: pillars
    plugin: feature_map
    inputs: [lidar]
    extraction: { range_min_m: 0.2, range_max_m: 14.5, no_return_m: 15.5, segment_jump_m: 0.3, background_m: 0.8, width_max_m: 0.8 }
    noise: { range_m: 0.04, bearing_deg: 0.4, tangential_m: 0.03 }
    existence: { view_range_m: 14, view_half_angle_deg: 130 }
  - { name: floor, plugin: occupancy_grid, inputs: [lidar], range_max_m: 14.5, no_return_m: 15.5, match: { evidence_tempering: 0.1 } }
  - { name: hall, plugin: octomap_grid, inputs: [lidar], resolution_m: 0.05, range_max_m: 14.5, no_return_m: 15.5, match: { evidence_tempering: 0.1 } }
filter: { particles: 10, seed: 1 }
sinks:
  - { plugin: tum }
  - { plugin: map_files }
)";

// Over four seeds of the first run 0.020 m at most; an octree without its pose is 0.29 to 1.30 m away.
constexpr double kOneFrame = 0.06;  // m

class MapManifest : public ::testing::Test {
 protected:
  /// Its first fix is a metre wrong: where its own frame lies on the Earth is estimated from then on.
  void drive_first(const std::vector<std::string>& more = {}, const std::string& out = "first") {
    write_text(folder_ / "robot.yaml", kRobot);
    std::vector<std::string> arguments{"run", at("robot.yaml"), "--quiet", "--out", at(out)};
    for (const char* key :
         {"source.gps.correlated_sigma_m=1", "source.gps.correlation_time_s=20", "sensors.gps.offset_sigma_m=1",
          "sensors.gps.offset_tau_s=20", "initial={ yaw_deg: 0, yaw_sigma_deg: 5 }"}) {
      arguments.insert(arguments.end(), {"--set", key});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome first = waymark(arguments);
    ASSERT_EQ(first.exit_code, 0) << first.err;
  }
  /// A later run, whose maps are those that are named here; fixes only find its start.
  Outcome drive_again(const std::vector<std::pair<std::string, std::string>>& loads, const std::string& alone = "",
                      const std::vector<std::string>& more = {}, const std::string& out = "second") {
    std::vector<std::string> arguments{"run", at("robot.yaml"), "--quiet", "--out", at(out)};
    for (const char* key : {"source.seed=2", "sensors.gps.fuse=start"})
      arguments.insert(arguments.end(), {"--set", key});
    for (const auto& [map, file] : loads) {
      arguments.insert(arguments.end(),
                       {"--set", "maps." + map + ".mode=localize", "--set", "maps." + map + ".load=" + file});
    }
    for (const std::string map : {"pillars", "floor", "hall"}) {
      if (!alone.empty() && map != alone)
        arguments.insert(arguments.end(), {"--set", "maps." + map + ".enabled=false"});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return waymark(arguments);
  }
  std::vector<std::pair<std::string, std::string>> all(const std::string& file) const {
    return {{"pillars", file}, {"floor", file}, {"hall", file}};
  }
  /// Between two runs, not aligned: what their maps say about where the robot is [m].
  double distance(const std::string& one, const std::string& other) const {
    const Outcome scored = waymark({"evaluate", "--json", "--estimate", at(one + "/trajectory.txt"), "--reference",
                                    at(other + "/trajectory.txt")});
    EXPECT_EQ(scored.exit_code, 0) << scored.err;
    return nlohmann::json::parse(scored.out)["trajectory"]["ate_rms_m"].get<double>();
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  std::string text(const std::string& name) const { return read_text(folder_ / name); }

  TemporaryFolder folder_;
};

TEST_F(MapManifest, LoadsAllLayersOfARunWithGpsInOneFrame) {
  drive_first();
  const std::string manifest = text("first/maps.yaml");
  SCOPED_TRACE(manifest);
  for (const char* layer :
       {"name: pillars, format: landmarks, file: pillars.landmarks.yaml }",
        "name: floor, format: map_server, file: floor.yaml }", "name: hall, format: octree, file: hall.ot, pose: {"}) {
    EXPECT_THAT(manifest, HasSubstr(layer));
  }
  ASSERT_EQ(drive_again(all("first/maps.yaml"), "", {}, "all").exit_code, 0);
  for (const char* alone : {"pillars", "floor", "hall"}) {
    const Outcome second = drive_again({{alone, "first/maps.yaml"}}, alone, {}, alone);
    ASSERT_EQ(second.exit_code, 0) << second.err;
    EXPECT_LT(distance(alone, "all"), kOneFrame) << alone;
  }

  // The octree without what the manifest says is elsewhere.
  std::filesystem::create_directory(folder_ / "plain");
  std::filesystem::copy_file(folder_ / "first/hall.ot", folder_ / "plain/hall.ot");
  ASSERT_EQ(drive_again({{"hall", "plain/hall.ot"}}, "hall", {}, "elsewhere").exit_code, 0);
  EXPECT_GT(distance("elsewhere", "all"), 0.2);
}

TEST_F(MapManifest, PlacesAFileThatIsLoadedWithoutIt) {
  drive_first();
  ASSERT_EQ(drive_again({{"hall", "first/maps.yaml"}}, "hall").exit_code, 0);
  const std::string by_manifest = text("second/trajectory.txt");
  ASSERT_EQ(drive_again({{"hall", "first/hall.ot"}}, "hall").exit_code, 0);
  EXPECT_EQ(text("second/trajectory.txt"), by_manifest);
}

TEST_F(MapManifest, IsWrittenAgainWhereTheLoadedLayersLie) {
  drive_first();
  ASSERT_EQ(drive_again(all("first/maps.yaml")).exit_code, 0);
  // They were only read.
  EXPECT_EQ(text("second/maps.yaml"), text("first/maps.yaml"));
  EXPECT_EQ(text("second/hall.ot"), text("first/hall.ot"));
  EXPECT_EQ(text("second/floor.pgm"), text("first/floor.pgm"));
}

TEST_F(MapManifest, OfAnotherFrameIsRefused) {
  drive_first({"--until", "10"});
  drive_first({"--until", "10"}, "other");
  const Outcome mixed = drive_again({{"pillars", "first/maps.yaml"}, {"hall", "other/maps.yaml"}});
  EXPECT_EQ(mixed.exit_code, 1);
  EXPECT_THAT(mixed.err, HasSubstr("maps: \"pillars\" and \"hall\" lie in different frames, "));
  EXPECT_THAT(mixed.err, HasSubstr("other/maps.yaml (without a datum); load both from one manifest"));

  for (const char* run : {"first", "other"}) {
    const std::string datum = std::string(run) == "first" ? "48,11,500" : "48,11.001,500";
    const Outcome placed = waymark({"map", "georeference", at(std::string(run) + "/maps.yaml"),
                                    at(std::string(run) + "_placed/maps.yaml"), "--datum", datum});
    ASSERT_EQ(placed.exit_code, 0) << placed.err;
  }
  const Outcome far = drive_again({{"pillars", "first_placed/maps.yaml"}, {"floor", "other_placed/maps.yaml"}});
  EXPECT_EQ(far.exit_code, 1);
  EXPECT_THAT(far.err, HasSubstr("other_placed/maps.yaml (datum 48, 11.001, 500 m); load both from one manifest"));
  const Outcome given =
      drive_again({{"floor", "first_placed/maps.yaml"}}, "", {"--set", "datum={latitude_deg: 47, longitude_deg: 11}"});
  EXPECT_EQ(given.exit_code, 1);
  EXPECT_THAT(given.err, HasSubstr("datum: 47, 11, 0 m is not that of the map \"floor\""));
}

TEST_F(MapManifest, HasALayerForAMapOrSaysSo) {
  drive_first({"--until", "10"});
  std::string manifest = text("first/maps.yaml");
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(manifest.find(from), std::string::npos);
    manifest.replace(manifest.find(from), from.size(), to);
    write_text(folder_ / "first/maps.yaml", manifest);
  };
  replace("name: floor", "name: ground");  // the only one of its format
  // It drives out of what the first run has seen in 10 s.
  const std::vector<std::string> may_be_lost{"--set", "health.max_lost_share=1"};
  EXPECT_EQ(drive_again({{"floor", "first/maps.yaml"}}, "floor", may_be_lost).exit_code, 0);
  replace("format: map_server", "format: picture");
  EXPECT_THAT(drive_again({{"floor", "first/maps.yaml"}}, "floor").err,
              HasSubstr("it has no layer \"floor\", and none of the format map_server"));
  replace("name: ground", "name: floor");
  EXPECT_THAT(drive_again({{"floor", "first/maps.yaml"}}, "floor").err,
              HasSubstr("its layer \"floor\" is of the format picture; map_server is expected"));
}

TEST_F(MapManifest, IsInspectedCroppedMergedAndMovedAsOneMap) {
  drive_first();
  ASSERT_EQ(drive_again(all("first/maps.yaml"), "", {}, "before").exit_code, 0);
  const Outcome info = waymark({"map", "info", at("first/maps.yaml")});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  for (const char* line : {"manifest of 3 layers", "datum       none", "layer       hall", "octree of OctoMap",
                           "grid of map_server", "list of landmarks"}) {
    EXPECT_THAT(info.out, HasSubstr(line));
  }

  // Two halves of a map together are the map.
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "map");
    const Outcome outcome = waymark(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  };
  run({"georeference", at("first/maps.yaml"), at("placed/maps.yaml"), "--datum", "48,11,500"});
  run({"crop", at("placed/maps.yaml"), at("west/maps.yaml"), "--box-m", "-50,-50,7,50"});
  run({"crop", at("placed/maps.yaml"), at("east/maps.yaml"), "--box-m", "7,-50,50,50"});
  EXPECT_LT(text("west/hall.ot").size(), text("first/hall.ot").size());
  run({"merge", at("west/maps.yaml"), at("east/maps.yaml"), at("whole/maps.yaml")});
  EXPECT_EQ(lines_of(text("whole/pillars.landmarks.yaml")).size(),
            lines_of(text("first/pillars.landmarks.yaml")).size());
  ASSERT_EQ(drive_again(all("whole/maps.yaml")).exit_code, 0);
  EXPECT_LT(distance("second", "before"), 0.02);

  // A picture of the octree lies where the octree does.
  run({"convert", at("first/maps.yaml"), at("slice.yaml"), "--layer", "hall", "--slice-m", "0.25,0.4"});
  ASSERT_EQ(drive_again({{"floor", "slice.yaml"}}, "floor").exit_code, 0);
  EXPECT_LT(distance("second", "before"), kOneFrame);

  // Moved away and back, through a datum 100 m north of it.
  run({"georeference", at("placed/maps.yaml"), at("moved/maps.yaml"), "--datum", "48.0009,11,500"});
  EXPECT_THAT(text("moved/maps.yaml"), HasSubstr("latitude_deg: 48.0009"));
  EXPECT_THAT(text("moved/pillars.landmarks.yaml"), Not(HasSubstr(text("placed/pillars.landmarks.yaml"))));
  run({"georeference", at("moved/maps.yaml"), at("back/maps.yaml"), "--datum", "48,11,500"});
  ASSERT_EQ(drive_again(all("back/maps.yaml")).exit_code, 0);
  EXPECT_LT(distance("second", "before"), 0.02);

  const Outcome apart = waymark({"map", "merge", at("placed/maps.yaml"), at("moved/maps.yaml"), at("no/maps.yaml")});
  EXPECT_EQ(apart.exit_code, 1);
  EXPECT_THAT(apart.err, HasSubstr("datum 48, 11, 500 m and datum 48.0009, 11, 500 m: maps in one frame"));
  const Outcome onto = waymark({"map", "crop", at("first/maps.yaml"), at("first/half.yaml"), "--box-m", "0,0,1,1"});
  EXPECT_EQ(onto.exit_code, 2);
  EXPECT_THAT(onto.err, HasSubstr("would overwrite what"));
}

}  // namespace
}  // namespace waymark::system_test
