// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/scan_spacing.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "waymark/base/time.hpp"

namespace waymark::scan_matching {
namespace {

class SpacingOfScans : public ::testing::Test {
 protected:
  bool takes(double t_s, double v_mps, double w_radps = 0.0) {
    const Time stamp{from_seconds(t_s)};
    const bool due = spacing_.is_due(stamp, {{v_mps, 0.0, 0.0}, {0.0, 0.0, w_radps}}, settings_);
    if (due) spacing_.take(stamp);
    return due;
  }

  ScanSettings settings_ = ScanSettings::read(Config::parse("{ update_distance_m: 0.5, update_angle_deg: 10 }"), 0.05);
  ScanSpacing spacing_;
};

TEST_F(SpacingOfScans, CountsTheWay) {
  EXPECT_TRUE(takes(0.0, 1.0));
  EXPECT_FALSE(takes(0.3, 1.0));
  EXPECT_TRUE(takes(0.6, -1.0));
  EXPECT_FALSE(takes(1.0, 1.0));
}

TEST_F(SpacingOfScans, CountsTurnsEitherWay) {
  EXPECT_TRUE(takes(0.0, 0.0));
  EXPECT_FALSE(takes(1.0, 0.0, -0.1));
  EXPECT_TRUE(takes(2.0, 0.0, 0.1));
}

TEST_F(SpacingOfScans, WhoStandsTakesOne) {
  EXPECT_TRUE(takes(0.0, 0.0));
  for (int k = 1; k < 1000; ++k) EXPECT_FALSE(takes(0.1 * k, 0.0));
}

TEST_F(SpacingOfScans, IfOnlyTheScansMeasureTheMotionAllAreTaken) {
  for (int k = 0; k < 10; ++k) {
    MotionWindow motion;  // at rest, as far as the maps know yet
    motion.is_measured = false;
    EXPECT_TRUE(spacing_.is_due(Time{from_seconds(0.1 * k)}, motion, settings_));
    spacing_.take(Time{from_seconds(0.1 * k)});
  }
}

TEST_F(SpacingOfScans, LateScansAreTaken) {
  EXPECT_TRUE(takes(1.0, 0.1));
  EXPECT_TRUE(takes(0.5, 0.1));
  EXPECT_FALSE(takes(1.5, 0.1));
}

TEST_F(SpacingOfScans, GoesOnFromACheckpoint) {
  EXPECT_TRUE(takes(1.0, 1.0));
  EXPECT_FALSE(takes(1.3, 1.0));
  std::stringstream file;
  OutArchive out(file);
  out(spacing_);
  spacing_ = {};
  InArchive in(file);
  in(spacing_);
  EXPECT_FALSE(takes(1.4, 1.0));
  EXPECT_TRUE(takes(1.6, 1.0));
}

}  // namespace
}  // namespace waymark::scan_matching
