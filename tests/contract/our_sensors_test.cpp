// SPDX-License-Identifier: Apache-2.0
// needs plugins: altimeter, compass, dgps, imu, odometry
#include <gtest/gtest.h>

#include "our_plugins.hpp"
#include "waymark/testing/sensor_contract.hpp"

namespace waymark::contract_test {
namespace {

using testing::check_sensor;
using testing::SensorSetting;
using testing::to_text;
using Motion = StateLayout::Motion;

const std::string kSystematic =
    ", speed_scale_sigma: 0.02, speed_scale_walk_per_sqrt_m: 1e-4, curvature_sigma_per_m: 0.01, "
    "curvature_walk_per_m_sqrt_m: 1e-5,"
    " yaw_scale_sigma: 0.02, yaw_scale_walk_per_sqrt_m: 1e-4, turn_loss_m: 0.01, turn_loss_sigma_m: 0.01";

void expect_good(const std::string& plugin, const std::string& yaml, const std::vector<Measurement>& measurements,
                 const SensorSetting& setting = {}) {
  for (const Motion motion : {Motion::planar, Motion::spatial}) {
    const auto sensor = make<Sensor>(plugin, yaml);
    EXPECT_EQ(to_text(check_sensor(*sensor, measurements, motion, setting)), "")
        << yaml << (motion == Motion::planar ? " planar" : " spatial");
  }
}

void expect_good_odometry(const std::string& model, const std::vector<Measurement>& measurements) {
  expect_good("odometry", "{ model: " + model + " }", measurements);
  expect_good("odometry", "{ model: " + model + kSystematic + " }", measurements);
  expect_good("odometry", "{ model: " + model + ", curvature_sigma_per_m: 0.01 }", measurements);
  expect_good("odometry", "{ model: " + model + ", vertical_noise_m_per_sqrt_s: [0.01, 0.1] }", measurements);
  expect_good("odometry", "{ model: " + model + ", vertical_noise_m_per_sqrt_s: none }", measurements);
}

TEST(OurOdometry, DifferentialKeepsTheContract) {
  expect_good_odometry("differential, track_m: 0.5", wheel_speeds(40));
}

TEST(OurOdometry, AckermannKeepsTheContract) {
  expect_good_odometry("ackermann, wheelbase_m: 2.83, encoder_left_m: 0.76",
                       stream_of<WheelSteering>(40, [](WheelSteering& w, double t) {
                         w.speed_mps = 2.0 + std::sin(t);
                         w.steering_rad = 0.4 * std::sin(0.7 * t);
                       }));
}

TEST(OurOdometry, TwistKeepsTheContract) {
  expect_good_odometry("twist", stream_of<BodyTwist>(40, [](BodyTwist& b, double t) {
                         b.v_x_mps = 1.0 + 0.3 * std::sin(t);
                         b.v_y_mps = 0.1 * std::cos(t);
                         b.w_z_radps = 0.5 * std::sin(2.0 * t);
                       }));
}

std::vector<Measurement> local_fixes() {
  return stream_of<GnssFix>(20, [](GnssFix& fix, double t) {
    fix.p_map_antenna = {3.0 + t, -2.0 + 0.5 * t, 1.0};
    fix.hdop = 1.0 + 0.1 * t;
    if (t > 1.0) fix.sigma_horizontal_m = 0.4;
    fix.type = GnssFix::Type::differential;
  });
}

TEST(OurDgps, LocalFixesKeepTheContract) {
  expect_good("dgps", "{ base_p_antenna_m: none, sigma_m: 0.3 }", local_fixes());
  expect_good("dgps", "{ base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3 }", local_fixes());
}

TEST(OurDgps, AnOffsetStateKeepsTheContract) {
  expect_good("dgps", "{ base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3, offset_sigma_m: 0.7, offset_tau_s: 60 }",
              local_fixes());
}

TEST(OurDgps, GeodeticFixesKeepTheContract) {
  SensorSetting setting;
  setting.datum = Datum{49.0157, 8.4258, 115.0};
  const auto fixes = stream_of<GnssFix>(20, [](GnssFix& fix, double t) {
    fix.latitude_deg = 49.0157 + 1e-5 * t;
    fix.longitude_deg = 8.4258 - 2e-5 * t;
    fix.height_m = 116.0;
  });
  expect_good("dgps", "{ base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3 }", fixes, setting);
  expect_good("dgps", "{ base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3, offset_sigma_m: 0.7 }", fixes, setting);
}

TEST(OurDgps, VelocityAndMonitoringKeepTheContract) {
  const auto fixes = stream_of<GnssFix>(120, [](GnssFix& fix, double t) {
    fix.p_map_antenna = {3.0 + t, -2.0 + 0.5 * t, 1.0};
    if (t > 2.0 && t < 3.0) fix.p_map_antenna.x() += 50.0 * t;
    if (t > 4.0 && t < 5.0) fix.p_map_antenna = {7.0, 0.0, 1.0};
    fix.satellites = t < 6.0 ? 9 : 5;
    fix.type = t < 7.0 ? GnssFix::Type::differential : GnssFix::Type::single;
    if (t > 1.0) {
      fix.speed_mps = 1.0 + 0.2 * t;
      fix.course_rad = 0.6 * t;
    }
  });
  const std::string velocity = ", velocity_sigma_mps: 0.1, course_sigma_deg: 2, good_satellites: 7";
  const std::string quick = ", adaptive_window: 5, outage_s: 0.2, settling_s: 1, jump_patience: 2 }";
  expect_good("dgps", "{ base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3" + velocity + quick, fixes);
  expect_good("dgps", "{ base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3, offset_sigma_m: 0.7" + velocity + quick,
              fixes);
}

/// The Earth's field near the equator in the compass' axes. (Where it is steep, a heading is so bent a function of the
/// tilt that differences are no measure for its Jacobian.)
template <class P, class Set>
std::vector<Measurement> fields(const Set& set) {
  auto stream = stream_of<P>(40, [&](P& payload, double t) {
    const Eigen::Quaterniond q_sensor_map =
        (so3::from_rpy(0.03 * std::sin(t), 0.02, 0.3 + 0.2 * t) * so3::from_rpy(0.05, 0.1, -0.7)).conjugate();
    const double disturbed = t > 2.0 && t < 2.5 ? 2.0 : 1.0;
    set(payload, q_sensor_map * (disturbed * Eigen::Vector3d(0.0, 39.7e-6, 10.6e-6)), q_sensor_map);
  });
  for (Measurement& m : stream) m.stamp += std::chrono::seconds(1'750'000'000);  // 2025: the model's time
  return stream;
}

TEST(OurCompass, HeadingsKeepTheContract) {
  const auto headings = stream_of<CompassHeading>(40, [](CompassHeading& compass, double t) {
    compass.heading_rad = 1.2 - 0.2 * t + (t > 2.0 && t < 2.5 ? 2.0 : 0.0);
    if (t > 1.0) compass.sigma_rad = 0.05;
    compass.from_true_north = t > 3.0;
  });
  expect_good("compass", "{ name: compass, declination_deg: 3 }", headings);
  expect_good("compass", "{ name: compass, declination: none, offset_sigma_deg: 4, jump_patience_s: 0.3 }", headings);
}

TEST(OurCompass, FieldsKeepTheContract) {
  const auto vectors =
      fields<MagneticField>([](MagneticField& field, const Eigen::Vector3d& m, const auto&) { field.m_sensor = m; });
  SensorSetting setting;
  setting.datum = Datum{0.0, 120.0, 0.0};
  expect_good("compass", "{ name: compass, declination: auto }", vectors, setting);
  expect_good("compass", "{ name: compass, declination_deg: -2, offset_sigma_deg: 4 }", vectors);
  expect_good("compass",
              "{ name: compass, declination_deg: 3, hard_iron_t: [1e-6, -2e-6, 3e-6],"
              "  soft_iron: [1.1, 0.02, 0, 0.02, 0.95, 0, 0, 0, 1] }",
              vectors);
}

TEST(OurCompass, TheMagnetometerOfAnImuKeepsTheContract) {
  const auto samples =
      fields<ImuSample>([](ImuSample& imu, const Eigen::Vector3d& m, const Eigen::Quaterniond& q_sensor_map) {
        imu.m_sensor = m;
        imu.f_sensor = q_sensor_map * Eigen::Vector3d(0.0, 0.0, 9.81);
      });
  expect_good("compass", "{ name: compass, declination_deg: 3 }", samples);
}

TEST(OurAltimeter, KeepsTheContract) {
  const auto heights = stream_of<Height>(20, [](Height& height, double t) {
    height.height_m = 2.0 + std::sin(t);
    if (t > 1.0) height.sigma_m = 0.3;
  });
  for (const std::string more : {"", ", offset_sigma_m: 0.5, offset_tau_s: 30", ", offset_sigma_m: 0.5"}) {
    const auto altimeter = make<Sensor>("altimeter", "{ name: altimeter, sigma_m: 0.1" + more + " }");
    EXPECT_EQ(to_text(check_sensor(*altimeter, heights, Motion::spatial)), "") << more;
  }
}

TEST(OurImu, KeepsTheContract) {
  const auto samples = stream_of<ImuSample>(40, [](ImuSample& imu, double t) {
    const Eigen::Quaterniond q_sensor_map =
        (so3::from_rpy(0.05 * std::sin(t), 0.0, 0.3 * t) * so3::from_rpy(0.2, -0.1, 1.5)).conjugate();
    imu.w_sensor = {0.05 * std::cos(t), 0.02, 0.3};
    imu.f_sensor = q_sensor_map * Eigen::Vector3d(0.1 * std::sin(t), 0.0, 9.81);
    imu.m_sensor = q_sensor_map * Eigen::Vector3d(0.0, 20e-6, -45e-6);
    imu.q_enu_sensor = q_sensor_map.conjugate();
  });
  expect_good("imu", "{ name: imu, orientation: device }", samples);
  SensorSetting other_states;  // none half a turn off the attitude, where the shortest way to it flips
  other_states.seed = 5;
  expect_good("imu", "{ name: imu, orientation: device, heading: true, declination_deg: 3 }", samples, other_states);
  expect_good("imu", "{ name: imu }", samples);
  expect_good("imu", "{ name: imu, heading: true }", samples, other_states);
  expect_good("imu", "{ name: imu, tilt: false, reports_standstill: false }", samples);
}

}  // namespace
}  // namespace waymark::contract_test
