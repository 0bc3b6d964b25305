// SPDX-License-Identifier: Apache-2.0
// Recorded logs of CARMEN: what is in them, counted, and where odometry ends.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// What a log holds.
struct Contents {
  std::size_t scans = 0;
  std::size_t beams = 0;  ///< of the last scan
  std::size_t steps = 0;
  double length_m = 0.0;
  Pose T_first_last;
  std::vector<std::string> notices;
  std::vector<BadRecord> bad;
};

class CarmenRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("WAYMARK_DATA");
    if (folder == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
    data_ = folder;
  }
  Contents read(const std::string& file, const std::string& wheels = "poses: scans",
                const std::string& more = "") const {
    const Config config = Config::parse("file: " + (data_ / file).string() +
                                        "\nlasers: [{ message: FLASER, sensor: lidar }]\nwheels: { sensor: wheels, " +
                                        wheels + " }\n" + more);
    const auto source =
        PluginLoader({WAYMARK_PLUGIN_DIR})
            .create<Source>("carmen", config, Rig({{"lidar", "", Pose{}}, {"wheels", "", std::nullopt}}));
    Contents contents;
    Time newest{};
    while (const auto m = source->next()) {
      EXPECT_TRUE(contents.scans == 0 || m->arrival >= newest);
      newest = m->arrival;
      if (m->payload->type() == LaserScan::kType) {
        ++contents.scans;
        contents.beams = m->as<LaserScan>().ranges_m.size();
        continue;
      }
      const auto& step = m->as<PoseIncrement>();
      ++contents.steps;
      contents.length_m += std::hypot(step.x_m, step.y_m);
      contents.T_first_last = contents.T_first_last * Pose::planar(step.x_m, step.y_m, step.yaw_rad);
    }
    contents.notices = source->notices();
    contents.bad = source->bad_records();
    return contents;
  }

  std::filesystem::path data_;
};

TEST_F(CarmenRecordings, Intel) {
  const Contents log = read("carmen_intel/intel.clf.gz");
  EXPECT_EQ(log.scans, 13631u);
  EXPECT_EQ(log.beams, 180u);
  EXPECT_EQ(log.steps, 13630u);
  // 508 m in the order of the lines; by its stamps odometry goes to and fro now and then.
  EXPECT_NEAR(log.length_m, 660.9, 0.1);
  EXPECT_THAT(log.bad, IsEmpty());
  EXPECT_THAT(log.notices, Contains(AllOf(HasSubstr("step back"), HasSubstr("631 FLASER"))));
  EXPECT_EQ(read("carmen_intel/intel.clf.gz", "poses: odom").steps, 26914u);
}

TEST_F(CarmenRecordings, Fr079GoesForwardInReverse) {
  const Contents log = read("carmen_fr079/fr079.clf.gz");
  EXPECT_EQ(log.scans, 4934u);
  EXPECT_EQ(log.beams, 360u);
  EXPECT_EQ(log.steps, 4933u);
  EXPECT_THAT(log.bad, IsEmpty());
  EXPECT_THAT(log.notices, Contains(AllOf(HasSubstr("in 233 steps"), HasSubstr("10.8 m in all"))));
  EXPECT_THAT(log.notices, Contains(HasSubstr("robot_frontlaser_offset is -0.04 m")));
  // Of the 422 intervals of ODOM that begin below -0.01 m/s nearly all go forward.
  EXPECT_THAT(read("carmen_fr079/fr079.clf.gz", "poses: odom").notices, Contains(HasSubstr("in 417 steps")));
}

TEST_F(CarmenRecordings, CsailHasNoOdomAndSparseLogsKeepTheWayBetweenScans) {
  const Contents raw = read("carmen_mit_csail/mit-csail.clf.gz");
  EXPECT_EQ(raw.scans, 1988u);
  EXPECT_EQ(raw.beams, 361u);
  EXPECT_NEAR(raw.length_m, 374.0, 1.0);
  const Contents sparse = read("carmen_rbpf_corrected/csail.log.gz", "poses: all", "times: lines");
  EXPECT_EQ(sparse.scans, 406u);
  EXPECT_EQ(sparse.steps, 1988u + 406u - 1u);
  EXPECT_NEAR(sparse.length_m, 374.0, 1.0);
}

}  // namespace
}  // namespace waymark
