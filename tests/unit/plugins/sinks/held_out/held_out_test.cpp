// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;

constexpr const char* kHeader = "t_s,sensor,x_m,y_m,z_m,latitude_deg,longitude_deg,height_m";

class HeldOutSink : public ::testing::Test {
 protected:
  HeldOutSink() { sink_->start({out_.path(), &rig_, nullptr}); }

  void write(const GnssFix& fix, Fate fate) {
    FakeSnapshot snapshot;
    snapshot.at(2.5, Pose());
    snapshot.measurement_.sensor = 1;
    snapshot.measurement_.payload = std::make_shared<GnssFix>(fix);
    snapshot.fate_ = fate;
    sink_->write(snapshot);
  }

  TemporaryFolder out_;
  Rig rig_{
      {{.name = "wheels", .payload = "", .T_base_sensor = {}}, {.name = "gps", .payload = "", .T_base_sensor = {}}}};
  std::shared_ptr<Sink> sink_ = make_sink("held_out");
};

TEST_F(HeldOutSink, WritesLocalFixes) {
  GnssFix fix;
  fix.p_map_antenna = {1.5, -2.0, 0.25};
  write(fix, Fate::held_out);
  sink_->finish(nullptr, {});
  const std::vector<std::string> expected{kHeader, "2.500000000,gps,1.500000,-2.000000,0.250000,,,"};
  EXPECT_EQ(out_.lines("held_out.csv"), expected);
}

TEST_F(HeldOutSink, LeavesAnUnknownHeightEmpty) {
  GnssFix fix;
  fix.p_map_antenna.head<2>() << 1.5, -2.0;
  write(fix, Fate::held_out);
  sink_->finish(nullptr, {});
  EXPECT_EQ(out_.lines("held_out.csv").at(1), "2.500000000,gps,1.500000,-2.000000,,,,");
}

TEST_F(HeldOutSink, WritesGeodeticFixesAsTheyAre) {
  GnssFix fix;
  fix.latitude_deg = -33.888;
  fix.longitude_deg = 151.19;
  fix.height_m = 20.0;
  write(fix, Fate::held_out);
  sink_->finish(nullptr, {});
  EXPECT_EQ(out_.lines("held_out.csv").at(1), "2.500000000,gps,,,,-33.8880000000,151.1900000000,20.000000");
}

TEST_F(HeldOutSink, WritesNoFileWithoutHeldOutFixes) {
  GnssFix fix;
  fix.p_map_antenna = {1.0, 2.0, 3.0};
  write(fix, Fate::fused);
  sink_->finish(nullptr, {});
  EXPECT_TRUE(std::filesystem::is_empty(out_.path()));
}

TEST_F(HeldOutSink, IgnoresOtherPayloads) {
  FakeSnapshot snapshot;
  snapshot.fate_ = Fate::held_out;
  sink_->write(snapshot);
  sink_->finish(nullptr, {});
  EXPECT_TRUE(std::filesystem::is_empty(out_.path()));
}

}  // namespace
}  // namespace waymark
