// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// Recorded bags against the CSV files that lie beside them and hold the same messages, to ten digits.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "rosbag1_fixture.hpp"

namespace waymark {
namespace {

using ::testing::IsEmpty;

class Rosbag1Recordings : public rosbag1_test::Rosbag1Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("WAYMARK_DATA");
    if (folder == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
    data_ = folder;
  }

  std::vector<Measurement> bag(const std::string& file, const std::string& channel) const {
    const auto source = make(channel, "file: " + (data_ / file).string());
    auto all = read_all(*source);
    EXPECT_THAT(source->bad_records(), IsEmpty());
    return all;
  }
  std::vector<Measurement> csv(const std::string& file, const std::string& payload_and_columns) const {
    const Config config = Config::parse("files: [{ path: " + (data_ / file).string() +
                                        ", sensor: a, time: t_stamp, arrival: t_rec, " + payload_and_columns + " }]");
    const auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("csv", config, rig_);
    return read_all(*source);
  }

  static bool same(double a, double b) {
    return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= 1e-9 * std::max(1e-6, std::abs(a));
  }
  static bool same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return same(a.x(), b.x()) && same(a.y(), b.y()) && same(a.z(), b.z());
  }
  /// `equal` says whether two payloads agree. Times in the CSV files have six digits and went through a double.
  template <class P, class Equal>
  static void expect_same(const std::vector<Measurement>& ours, const std::vector<Measurement>& theirs,
                          std::size_t count, const Equal& equal) {
    ASSERT_EQ(ours.size(), count);
    ASSERT_EQ(theirs.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_LE(std::abs((ours[i].stamp - theirs[i].stamp).count()), 650) << i;
      EXPECT_LE(std::abs((ours[i].arrival - theirs[i].arrival).count()), 650) << i;
      ASSERT_TRUE(equal(ours[i].as<P>(), theirs[i].as<P>())) << i;
    }
  }
  static bool same_imu(const ImuSample& a, const ImuSample& b) {
    // Ten digits make the quaternion a unit again only nearly.
    return same(a.w_sensor, b.w_sensor) && same(a.f_sensor, b.f_sensor) &&
           (a.q_enu_sensor.coeffs() - b.q_enu_sensor.coeffs()).norm() < 1e-8;
  }
  static bool same_twist(const BodyTwist& a, const BodyTwist& b) {
    return same(a.v_x_mps, b.v_x_mps) && same(a.v_y_mps, b.v_y_mps) && same(a.w_z_radps, b.w_z_radps);
  }

  std::filesystem::path data_;
};

const std::string kImuColumns =
    "payload: ImuSample, columns: { w_x_radps: wx_radps, w_y_radps: wy_radps, w_z_radps: wz_radps, f_x_mps2: ax_mps2,"
    " f_y_mps2: ay_mps2, f_z_mps2: az_mps2, q_w: qw, q_x: qx, q_y: qy, q_z: qz }";
const std::string kTwistColumns =
    "payload: BodyTwist, columns: { v_x_mps: vx_mps, v_y_mps: vy_mps, w_z_radps: wz_radps }";

TEST_F(Rosbag1Recordings, HuskyIsWhatItsCsvFilesSay) {
  const std::string file = "rl_husky/test1.bag";
  expect_same<ImuSample>(bag(file, "{ topic: /imu/data, sensor: a }"), csv("rl_husky/imu_data.csv.gz", kImuColumns),
                         11865, same_imu);
  expect_same<BodyTwist>(bag(file, "{ topic: /husky_velocity_controller/odom, sensor: a }"),
                         csv("rl_husky/husky_velocity_controller_odom.csv.gz", kTwistColumns), 3952, same_twist);
  const std::string columns =
      "payload: GnssFix, columns: { latitude_deg: lat_deg, longitude_deg: lon_deg, height_m: alt_m,"
      " type: { column: status, map: { -1: none, 0: single, 1: differential, 2: differential } } }";
  expect_same<GnssFix>(bag(file, "{ topic: /fix, sensor: a }"), csv("rl_husky/fix.csv.gz", columns), 989,
                       [](const GnssFix& a, const GnssFix& b) {
                         return same(a.latitude_deg, b.latitude_deg) && same(a.longitude_deg, b.longitude_deg) &&
                                same(a.height_m, b.height_m) && a.type == b.type && a.sigma_horizontal_m >= 0.8 &&
                                a.sigma_horizontal_m <= 1.7;
                       });
}

TEST_F(Rosbag1Recordings, ArdroneIsWhatItsCsvFilesSay) {
  const std::string file = "rl_ardrone/test3.bag";
  const std::string odometry = "rl_ardrone/ardrone_odometry_raw.csv.gz";
  expect_same<ImuSample>(bag(file, "{ topic: /ardrone/imu, sensor: a }"),
                         csv("rl_ardrone/ardrone_imu.csv.gz", kImuColumns), 25217, same_imu);
  expect_same<BodyTwist>(bag(file, "{ topic: /ardrone/odometry/raw, sensor: a }"), csv(odometry, kTwistColumns), 25217,
                         same_twist);
  expect_same<Height>(bag(file, "{ topic: /ardrone/odometry/raw, sensor: a, payload: Height }"),
                      csv(odometry, "payload: Height, columns: { height_m: z_m }"), 25217,
                      [](const Height& a, const Height& b) { return same(a.height_m, b.height_m); });
}

}  // namespace
}  // namespace waymark
