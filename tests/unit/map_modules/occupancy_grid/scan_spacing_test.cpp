// SPDX-License-Identifier: Apache-2.0
#include "scan_spacing.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "waymark/time.hpp"

namespace waymark::grid {
namespace {

class SpacingOfScans : public ::testing::Test {
 protected:
  bool takes(double t_s, double x, double y = 0.0, double yaw = 0.0) {
    return spacing_.takes(Time{from_seconds(t_s)}, {{}, {}, Pose::planar(x, y, yaw)}, settings_);
  }

  ScanSettings settings_ = ScanSettings::read(Config::parse("{ update_distance_m: 0.5, update_angle_deg: 10 }"), 0.05);
  ScanSpacing spacing_;
};

TEST_F(SpacingOfScans, CountsTheWayFromPlaceToPlace) {
  EXPECT_TRUE(takes(0.0, 0.0));
  EXPECT_FALSE(takes(0.1, 0.4));
  EXPECT_TRUE(takes(0.2, 0.6));
  EXPECT_FALSE(takes(0.3, 0.6, 0.49));
  EXPECT_TRUE(takes(0.4, 0.6, 0.51));
}

TEST_F(SpacingOfScans, CountsTurnsThroughHalfACircle) {
  EXPECT_TRUE(takes(0.0, 0.0, 0.0, 3.1));
  EXPECT_FALSE(takes(0.1, 0.0, 0.0, -3.1));
  EXPECT_TRUE(takes(0.2, 0.0, 0.0, -3.0));
}

/// To and fro, or round a corner: what was driven counts.
TEST_F(SpacingOfScans, SumsUpTheWay) {
  EXPECT_TRUE(takes(0.0, 0.0));
  EXPECT_FALSE(takes(0.1, 0.3));
  EXPECT_FALSE(takes(0.2, 0.15));
  EXPECT_TRUE(takes(0.3, 0.15, 0.1));
  EXPECT_FALSE(takes(0.4, 0.15, 0.1, 0.1));
  EXPECT_TRUE(takes(0.5, 0.15, 0.1, 0.0));
}

/// A log whose times are useless has speeds that are, too: the way does not ask for them.
TEST_F(SpacingOfScans, AsksForNoSpeed) {
  EXPECT_TRUE(takes(0.0, 0.0));
  EXPECT_TRUE(spacing_.takes(Time{from_seconds(1e-9)}, {{}, {}, Pose::planar(1.0, 0.0, 0.0)}, settings_));
  EXPECT_FALSE(spacing_.takes(Time{from_seconds(5.0)}, {{9.0, 0.0, 0.0}, {0.0, 0.0, 9.0}, Pose::planar(1.0, 0.0, 0.0)},
                              settings_));
}

TEST_F(SpacingOfScans, LateScansAreTaken) {
  EXPECT_TRUE(takes(1.0, 0.0));
  EXPECT_TRUE(takes(0.5, 0.0));
  EXPECT_FALSE(takes(1.5, 0.1));
}

TEST_F(SpacingOfScans, GoesOnFromACheckpoint) {
  EXPECT_TRUE(takes(1.0, 2.0));
  std::stringstream file;
  OutArchive out(file);
  spacing_.save(out);
  spacing_ = {};
  InArchive in(file);
  spacing_.load(in);
  EXPECT_FALSE(takes(1.1, 2.1));
  EXPECT_TRUE(takes(1.2, 2.6));
}

}  // namespace
}  // namespace waymark::grid
