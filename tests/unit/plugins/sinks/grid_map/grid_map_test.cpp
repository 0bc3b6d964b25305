// SPDX-License-Identifier: Apache-2.0
// needs plugins: grid_map
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

/// Two cells in a row, the right one occupied, over one unknown and one free cell.
MapDescription dense_map(const std::string& name) {
  MapDescription map;
  map.module = name;
  map.grid = GridView{Pose::planar(-1.0, 2.0, 0.5), 0.25, 2, 2, {GridView::kUnknown, 0, 0, 100}};
  return map;
}

TEST(GridMapSink, WritesWhatMapServerReads) {
  const TemporaryFolder out;
  const auto sink = make_sink("grid_map");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.maps_ = {dense_map("hall")};
  sink->finish(&snapshot, {});
  EXPECT_THAT(out.read("hall.pgm"), testing::EndsWith(std::string("\xFE\0\xCD\xFE", 4))) << "the upper row comes first";
  EXPECT_THAT(out.read("hall.yaml"), AllOf(HasSubstr("image: hall.pgm"), HasSubstr("resolution: 0.25")));
}

TEST(GridMapSink, LeavesMapsWithoutAGridOut) {
  const TemporaryFolder out;
  const auto sink = make_sink("grid_map");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  MapDescription trees;
  trees.module = "trees";
  snapshot.maps_ = {trees, dense_map("config")};
  sink->finish(&snapshot, {});
  EXPECT_FALSE(std::filesystem::exists(out / "trees.yaml"));
  EXPECT_FALSE(std::filesystem::exists(out / "config.yaml")) << "the effective configuration has that name";
  EXPECT_TRUE(std::filesystem::exists(out / "config_2.yaml"));
}

TEST(GridMapSink, ARunThatNeverStartedLeavesNothing) {
  const TemporaryFolder out;
  const auto sink = make_sink("grid_map");
  sink->start({out.path(), nullptr, nullptr});
  sink->finish(nullptr, {});
  EXPECT_TRUE(std::filesystem::is_empty(out.path()));
}

}  // namespace
}  // namespace waymark
