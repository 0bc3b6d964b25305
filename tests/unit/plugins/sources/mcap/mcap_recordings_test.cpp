// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// A recorded MCAP file against the CSV files that lie beside it and hold the same messages.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>

#include "mcap_fixture.hpp"

namespace waymark::mcap_test {
namespace {

using testing::IsEmpty;

class McapRecordings : public McapSourceTest {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("WAYMARK_DATA");
    if (folder == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
    data_ = std::filesystem::path(folder) / "cougars_auv_mcap";
  }
  std::vector<Measurement> mcap(const std::string& channel) const {
    const auto source = make(channel, "file: " + (data_ / "SO_lastbag_mcap_0.mcap.gz").string());
    auto all = read_all(*source);
    EXPECT_THAT(source->bad_records(), IsEmpty());
    return all;
  }
  std::vector<Measurement> csv(const std::string& file, const std::string& payload_and_columns,
                               const std::string& time = "t_s") const {
    const Config config = Config::parse("max_time_jump_s: 1e8\nfiles: [{ path: " + (data_ / file).string() +
                                        ", sensor: a, empty_is_unknown: true, time: " + time + ", arrival: t_rec_s, " +
                                        payload_and_columns + " }]");
    const auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("csv", config, rig_);
    return read_all(*source);
  }
  template <class P, class Same>
  static void expect_same(const std::vector<Measurement>& ours, const std::vector<Measurement>& theirs,
                          std::size_t count, const Same& same) {
    ASSERT_EQ(ours.size(), count);
    ASSERT_EQ(theirs.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      // Times in the CSV files have six digits, and went through a double (step 240 ns).
      EXPECT_LE(std::abs((ours[i].stamp - theirs[i].stamp).count()), 750) << i;
      EXPECT_LE(std::abs((ours[i].arrival - theirs[i].arrival).count()), 750) << i;
      ASSERT_TRUE(same(ours[i].as<P>(), theirs[i].as<P>())) << i;
    }
  }
  static bool close(double a, double b) {
    return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= 1e-8 * std::max(1e-3, std::abs(a));
  }

  std::filesystem::path data_;
};

TEST_F(McapRecordings, TheVelocityOfTheDvlIsReadByItsDefinition) {
  expect_same<BodyTwist>(mcap("{ topic: /coug2/dvl/velocity, sensor: a, payload: BodyTwist,"
                              " fields: { v_x_mps: twist.twist.linear.x, v_y_mps: -twist.twist.linear.y,"
                              " w_z_radps: twist.twist.linear.z } }"),
                         csv("dvl.csv.gz",
                             "payload: BodyTwist, columns: { v_x_mps: vx_mps, v_y_mps: { column: vy_mps, scale: -1 },"
                             " w_z_radps: vz_mps }"),
                         658, [](const BodyTwist& a, const BodyTwist& b) {
                           return close(a.v_x_mps, b.v_x_mps) && close(a.v_y_mps, b.v_y_mps) &&
                                  close(a.w_z_radps, b.w_z_radps);
                         });
}

TEST_F(McapRecordings, TheImuHasOnlyTheTimeOfRecording) {
  expect_same<ImuSample>(
      mcap("{ topic: /coug2/modem_imu, sensor: a, stamp: recorded }"),
      csv("imu.csv.gz",
          "payload: ImuSample, columns: { w_x_radps: gx, w_y_radps: gy, w_z_radps: gz, f_x_mps2: ax, f_y_mps2: ay,"
          " f_z_mps2: az, q_w: qw, q_x: qx, q_y: qy, q_z: qz }",
          "t_rec_s"),
      1196, [](const ImuSample& a, const ImuSample& b) {
        return (a.w_sensor - b.w_sensor).norm() < 1e-7 && (a.f_sensor - b.f_sensor).norm() < 1e-7 &&
               (a.q_enu_sensor.coeffs() - b.q_enu_sensor.coeffs()).norm() < 1e-7;
      });
}

TEST_F(McapRecordings, TheDepthIsThatOfItsPoses) {
  expect_same<Height>(mcap("{ topic: /coug2/depth_data, sensor: a, payload: Height }"),
                      csv("depth.csv.gz", "payload: Height, columns: { height_m: z_m }"), 1566,
                      [](const Height& a, const Height& b) { return close(a.height_m, b.height_m); });
}

TEST_F(McapRecordings, TheFixesAreThoseOfTheReceiver) {
  std::vector<Measurement> fixes = mcap("{ topic: /coug2/fix, sensor: a }");
  EXPECT_EQ(fixes.size(), 263U);
  // Under water the receiver leaves the status as it was, and reports a position that is not a number.
  std::erase_if(fixes, [](const Measurement& m) { return std::isnan(m.as<GnssFix>().latitude_deg); });
  const Config config = Config::parse(
      "max_time_jump_s: 1e8\nmax_bad_rows: 300\nfiles: [{ path: " + (data_ / "gps.csv.gz").string() +
      ", sensor: a, time: t_s, arrival: t_rec_s, payload: GnssFix, columns: { latitude_deg: lat_deg, "
      "longitude_deg: lon_deg, height_m: alt_m, type: { column: status, map: { -1: none, 0: single } } } }]");
  const auto csv = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("csv", config, rig_);
  expect_same<GnssFix>(fixes, read_all(*csv), 1, [](const GnssFix& a, const GnssFix& b) {
    return close(a.latitude_deg, b.latitude_deg) && close(a.longitude_deg, b.longitude_deg) && a.type == b.type;
  });
}

}  // namespace
}  // namespace waymark::mcap_test
