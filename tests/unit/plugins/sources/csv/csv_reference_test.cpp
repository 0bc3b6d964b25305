// SPDX-License-Identifier: Apache-2.0
// References in six degrees of freedom, of a sensor, and without any file of measurements.
#include <gmock/gmock.h>

#include <numbers>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using ::testing::HasSubstr;

/// A pose of a sensor that is mounted 1 m before and 2 m above the base, and looks to the left.
class CsvReference : public CsvTest {
 protected:
  CsvReference() {
    rig_ = Rig({{"lidar", "", Pose{so3::from_rpy(0.0, 0.0, std::numbers::pi / 2.0), {1.0, 0.0, 2.0}}}});
    write("truth.csv", "t,x,y,z,qx,qy,qz,qw\n1,10,20,30,0,0,0.70710678,0.70710678\n");
  }
  std::shared_ptr<const Reference> read(const std::string& keys, const std::string& columns) const {
    return make("files: []\nreference: { trajectory: { path: truth.csv, " + keys +
                "columns: { time: t, x_m: x, y_m: y, " + columns + " } } }")
        ->reference();
  }
};

constexpr const char* kQuaternion = "q_w: qw, q_x: qx, q_y: qy, q_z: qz";

TEST_F(CsvReference, MayStandAlone) {
  const auto source =
      make("files: []\nreference: { trajectory: { path: truth.csv, columns: { time: t, x_m: x, y_m: y } } }");
  EXPECT_TRUE(source->channels().empty());
  EXPECT_FALSE(source->next());
  EXPECT_EQ(source->progress(), 1.0);
  EXPECT_EQ(source->reference()->trajectory.size(), 1U);
  EXPECT_THAT(construction_error<ConfigError>("files: []"), HasSubstr("at least one file is expected, or a reference"));
}

TEST_F(CsvReference, HasSixDegreesOfFreedomWithAHeight) {
  write("truth.csv", "t,x,y,z,qx,qy,qz,qw\n1,10,20,30,0.5,0.5,0.5,0.5\n");
  const auto spatial = read("", std::string("z_m: z, ") + kQuaternion)->trajectory.at(0);
  EXPECT_EQ(spatial.T_map_base.p, Eigen::Vector3d(10.0, 20.0, 30.0));
  EXPECT_TRUE(spatial.T_map_base.q.isApprox(Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5)));
  const auto planar = read("", kQuaternion)->trajectory.at(0);
  EXPECT_EQ(planar.T_map_base.p.z(), 0.0);
  EXPECT_NEAR(so3::to_rpy(planar.T_map_base.q).head<2>().norm(), 0.0, 1e-12);
}

TEST_F(CsvReference, OfASensorIsTurnedIntoThatOfTheBase) {
  // The sensor's yaw is a quarter turn, so that of the base is none.
  const auto spatial = read("sensor: lidar, ", std::string("z_m: z, ") + kQuaternion)->trajectory.at(0);
  EXPECT_TRUE(spatial.T_map_base.p.isApprox(Eigen::Vector3d(9.0, 20.0, 28.0), 1e-6));
  EXPECT_NEAR(spatial.T_map_base.yaw(), 0.0, 1e-6);
  const auto planar = read("sensor: lidar, ", kQuaternion)->trajectory.at(0);
  EXPECT_TRUE(planar.T_map_base.p.isApprox(Eigen::Vector3d(9.0, 20.0, 0.0), 1e-6));
  const std::string yaml = "files: []\nreference: { trajectory: { path: truth.csv, sensor: ";
  EXPECT_THAT(construction_error<ConfigError>(yaml + "lidar, columns: { time: t, x_m: x, y_m: y } } }"),
              HasSubstr("sensor: needs the attitude"));
  EXPECT_THAT(construction_error<ConfigError>(yaml + "lida, columns: { time: t, x_m: x, y_m: y } } }"),
              HasSubstr("there is no sensor \"lida\" under sensors"));
}

}  // namespace
}  // namespace waymark
