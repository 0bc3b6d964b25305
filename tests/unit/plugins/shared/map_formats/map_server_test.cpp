// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/map_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::map_formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint8_t kUnknown = GridView::kUnknown;

/// Two rows of three cells.
GridView small_grid() { return {Pose::planar(-2.0, 3.0, 0.5), 0.25, 3, 2, {0, 20, kUnknown, 100, 80, 50}}; }

class MapServer : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }

  test::TemporaryFolder folder_;
};

TEST_F(MapServer, ReadsWhatWasWritten) {
  write("hall.pgm", greymap_text(small_grid()));
  write("hall.yaml", legend_text(small_grid(), "hall.pgm"));
  const GridView read = read_map_server(folder_ / "hall.yaml");
  EXPECT_EQ(read.width, 3);
  EXPECT_EQ(read.height, 2);
  EXPECT_DOUBLE_EQ(read.resolution_m, 0.25);
  EXPECT_NEAR(read.T_map_grid.p.x(), -2.0, 1e-9);
  EXPECT_NEAR(read.T_map_grid.p.y(), 3.0, 1e-9);
  EXPECT_NEAR(read.T_map_grid.yaw(), 0.5, 1e-9);
  EXPECT_THAT(read.cells, ElementsAre(0, 0, kUnknown, 100, 100, kUnknown)) << "cells are free, occupied or unknown";
}

TEST_F(MapServer, NamesTheLineOfAPictureThatIsMissing) {
  write("hall.yaml", legend_text(small_grid(), "other.pgm"));
  try {
    read_map_server(folder_ / "hall.yaml");
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("hall.yaml:1"));
    EXPECT_THAT(error.what(), HasSubstr("other.pgm"));
  }
}

}  // namespace
}  // namespace waymark::map_formats
