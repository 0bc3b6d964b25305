// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

Rig example() {
  return Rig({{.name = "wheels", .payload = "", .T_base_sensor = std::nullopt},
              {.name = "lidar", .payload = "waymark/LaserScan@1", .T_base_sensor = Pose::planar(3.78, 0.5, 0.1)}});
}

TEST(Rig, FindsSensorsInTheirOrder) {
  const Rig rig = example();
  EXPECT_EQ(rig.find("wheels"), 0);
  EXPECT_EQ(rig.find("lidar"), 1);
  EXPECT_EQ(rig.find("Lidar"), -1);
  EXPECT_EQ(rig.mountings().size(), 2u);
}

TEST(Rig, GivesTheExtrinsics) {
  const Rig rig = example();
  EXPECT_EQ(rig.T_base_sensor("lidar").p, Eigen::Vector3d(3.78, 0.5, 0.0));
  EXPECT_NEAR(rig.T_base_sensor("lidar").yaw(), 0.1, 1e-15);
}

TEST(Rig, NamesTheSensorWhoseExtrinsicsAreMissing) {
  EXPECT_THAT([] { example().T_base_sensor("wheels"); },
              ThrowsMessage<ConfigError>(AllOf(HasSubstr("sensors.wheels"), HasSubstr("base_T_sensor is missing"))));
}

TEST(Rig, GivesTheIntrinsicsOrNamesTheCameraThatHasNone) {
  const Rig rig({{.name = "front", .payload = "", .T_base_sensor = {}, .intrinsics = Intrinsics{.width = 640}}});
  EXPECT_EQ(rig.intrinsics("front").width, 640);
  EXPECT_THAT([] { example().intrinsics("lidar"); },
              ThrowsMessage<ConfigError>(AllOf(HasSubstr("sensors.lidar"), HasSubstr("intrinsics are missing"))));
}

TEST(Rig, ListsTheSensorsIfThereIsNoSuch) {
  EXPECT_THAT([] { example().T_base_sensor("lidra"); },
              ThrowsMessage<ConfigError>(AllOf(HasSubstr("lidra"), HasSubstr("wheels, lidar"))));
  EXPECT_THROW(Rig({}).T_base_sensor("lidar"), ConfigError);
}

}  // namespace
}  // namespace waymark
