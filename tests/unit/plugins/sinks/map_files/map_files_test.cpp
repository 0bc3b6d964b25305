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
  EXPECT_EQ(files_in(out.path()), 4u) << "nothing of a map without files, no partial file";
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
