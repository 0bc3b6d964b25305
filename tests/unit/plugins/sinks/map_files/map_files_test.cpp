// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "unit/plugins/sinks/fake_snapshot.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;

const std::string kBytes("# a map\n\0\xff\x01", 11);

MapDescription map_named(const std::string& name) {
  MapDescription map;
  map.module = name;
  map.files = {{".bt", kBytes}, {".ot", "second"}};
  return map;
}

std::size_t files_in(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator files(folder);
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

TEST(MapFilesSink, WritesEveryFileOfEveryMapAsItIs) {
  const TemporaryFolder out;
  const auto sink = make_sink("map_files");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.maps_ = {map_named("hall"), {"trees", {}}, map_named("../2nd floor")};
  sink->finish(&snapshot, {});
  EXPECT_EQ(out.read("hall.bt"), kBytes);
  EXPECT_EQ(out.read("hall.ot"), "second");
  EXPECT_EQ(out.read("___2nd_floor.bt"), kBytes);
  EXPECT_EQ(files_in(out.path()), 5u) << "nothing of a map without files, no partial file; the manifest";
}

TEST(MapFilesSink, NamesOneFileOfEveryMapInTheManifestAndWhereItLies) {
  const TemporaryFolder out;
  const auto sink = make_sink("map_files");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  MapDescription floor;
  floor.module = "floor";
  floor.grid = GridView{Pose::planar(1.0, 2.0, 0.0), 0.1, 2, 1, {0, 100}};
  snapshot.maps_ = {map_named("hall"), floor, map_named("maps"), {"empty", {}}};
  for (MapFile& file : snapshot.maps_[0].files) file.T_enu_file = Pose::planar(4.0, -1.0, 0.0);
  sink->finish(&snapshot, {});
  const std::string manifest = out.read("maps.yaml");
  for (const char* layer :
       {"{ name: hall, format: octree, file: hall.ot, pose: { x_m: 4, y_m: -1, z_m: 0, yaw_deg: 0 } }",
        "{ name: floor, format: map_server, file: floor.yaml }", "{ name: maps, format: octree, file: maps_2.ot }"}) {
    EXPECT_NE(manifest.find(layer), std::string::npos) << manifest;
  }
  EXPECT_EQ(manifest.find("empty"), std::string::npos);
  EXPECT_NE(out.read("floor.yaml").find("image: floor.pgm"), std::string::npos);
}

TEST(MapFilesSink, MapsWhoseNamesBecomeTheSameFileAreKeptApart) {
  const TemporaryFolder out;
  const auto sink = make_sink("map_files");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.maps_ = {map_named("hall 1"), map_named("hall_1"), map_named("config")};
  snapshot.maps_[0].files = {{".bt", "first"}};
  sink->finish(&snapshot, {});
  EXPECT_EQ(out.read("hall_1.bt"), "first");
  EXPECT_EQ(out.read("hall_1_2.bt"), kBytes);
  EXPECT_EQ(out.read("config_2.bt"), kBytes) << "config.yaml is the run's own";
}

TEST(MapFilesSink, ARunThatNeverStartedLeavesNothing) {
  const TemporaryFolder out;
  const auto sink = make_sink("map_files");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.maps_ = {map_named("hall")};
  snapshot.started_ = false;
  sink->finish(&snapshot, {});
  sink->finish(nullptr, {});
  EXPECT_EQ(files_in(out.path()), 0u);
}

TEST(MapFilesSink, TellsWhichFileCannotBeWritten) {
  const TemporaryFolder out;
  const auto sink = make_sink("map_files");
  sink->start({out.path() / "gone", nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.maps_ = {map_named("hall")};
  try {
    sink->finish(&snapshot, {});
    FAIL() << "written into a folder that is not there";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("hall.bt"), std::string::npos) << error.what();
  }
}

TEST(MapFilesSink, HasNoKeys) {
  const Config config = Config::parse("{ file: map.bt }");
  const PluginLoader loader({WAYMARK_PLUGIN_DIR});
  EXPECT_NO_THROW(loader.create<Sink>("map_files", config, Rig({})));
  EXPECT_THROW(config.reject_unread(), ConfigError);
}

}  // namespace
}  // namespace waymark
