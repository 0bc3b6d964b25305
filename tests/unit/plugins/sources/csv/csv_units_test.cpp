// SPDX-License-Identifier: Apache-2.0
// Columns in units of their own, and values that a file lacks.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

class CsvUnits : public CsvTest {
 protected:
  /// Of a file a.csv with the time in column t, for the sensor `camera`.
  static std::string entry(const std::string& more) {
    return "files: [{ path: a.csv, sensor: camera, time: t, " + more + " }]";
  }
  Measurement first(const std::string& more) const { return *make(entry(more))->next(); }
};

TEST_F(CsvUnits, ANameOfAFieldMayEndInAnotherUnit) {
  write("a.csv", "t,v,s,h,lat,alt\n0,36,90,-45,0.5,1000\n");
  const auto wheels = first("payload: WheelSteering, columns: { speed_kmh: v, steering_deg: s }");
  EXPECT_NEAR(wheels.as<WheelSteering>().speed_mps, 10.0, 1e-14);
  EXPECT_EQ(wheels.as<WheelSteering>().steering_rad, 90.0 * kRadPerDeg);
  const auto compass = first("payload: CompassHeading, columns: { heading_deg: h, sigma_mrad: v }");
  EXPECT_EQ(compass.as<CompassHeading>().heading_rad, -45.0 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(compass.as<CompassHeading>().sigma_rad, 0.036);
  const auto fix = first("payload: GnssFix, columns: { latitude_rad: lat, longitude_deg: h, height_ft: alt }");
  EXPECT_DOUBLE_EQ(fix.as<GnssFix>().latitude_deg, 0.5 / kRadPerDeg);
  EXPECT_DOUBLE_EQ(fix.as<GnssFix>().height_m, 304.8);
}

TEST_F(CsvUnits, AColumnMaySayItsUnit) {
  write("a.csv", "t,wx,wy,wz,fx,mx\n0,180,-90,30,2,50\n");
  const auto sample =
      first(
          "payload: ImuSample, columns: { w_x: { column: wx, unit: deg/s }, w_y_radps: { column: wy, unit: degps },"
          " w_z: { column: wz, unit: rpm }, f_x: { column: fx, unit: g }, f_y_g: fx, f_z_mg: fx,"
          " m_x: { column: mx, unit: uT }, m_y_ut: mx, m_z_gauss: mx }")
          .as<ImuSample>();
  EXPECT_DOUBLE_EQ(sample.w_sensor.x(), std::numbers::pi);
  EXPECT_DOUBLE_EQ(sample.w_sensor.y(), -0.5 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(sample.w_sensor.z(), std::numbers::pi);
  EXPECT_TRUE(sample.f_sensor.isApprox(9.80665 * Eigen::Vector3d(2.0, 2.0, 2e-3), 1e-15));
  EXPECT_TRUE(sample.m_sensor.isApprox(Eigen::Vector3d(50e-6, 50e-6, 50e-4), 1e-15));
}

TEST_F(CsvUnits, ScaleAndOffsetComeBeforeTheUnit) {
  write("a.csv", "t,h\n0,900\n");
  const auto compass = first("payload: CompassHeading, columns: { heading_deg: { column: h, scale: 0.1, offset: 3 } }");
  EXPECT_DOUBLE_EQ(compass.as<CompassHeading>().heading_rad, 93.0 * kRadPerDeg);
}

TEST_F(CsvUnits, RangesOfColumnsHaveUnits) {
  write("a.csv", "t,a,b\n0,1500,250\n");
  const std::string scan = ", scan: { start_deg: 0, step_deg: 1 }";
  const auto by_name = first("payload: LaserScan, columns: { ranges_mm: { first: a, last: b } }" + scan);
  EXPECT_THAT(by_name.as<LaserScan>().ranges_m, ElementsAre(1.5f, 0.25f));
  const auto by_key = first("payload: LaserScan, columns: { ranges: { first: a, last: b, unit: cm } }" + scan);
  EXPECT_THAT(by_key.as<LaserScan>().ranges_m, ElementsAre(15.0f, 2.5f));
}

TEST_F(CsvUnits, TotalsInTheirUnitWrapInRawNumbers) {
  write("a.csv", "t,l,r\n0,990,0\n1,10,100\n");
  const auto motion = first(
      "payload: PoseIncrement, columns: { left_mm: l, right_mm: r }, cumulative: { wraps_at: 1000 }, track_m: 0.4");
  EXPECT_NEAR(motion.as<PoseIncrement>().yaw_rad, (0.1 - 0.02) / 0.4, 1e-12);
}

TEST_F(CsvUnits, UnitsThatDoNotFitAreRefused) {
  write("a.csv", "t,h\n0,1\n");
  const auto error = [this](const std::string& columns) {
    return construction_error<ConfigError>(entry("payload: CompassHeading, columns: { " + columns + " }"));
  };
  EXPECT_THAT(error("heading: { column: h, unit: m }"),
              AllOf(HasSubstr("run.yaml:1:"), HasSubstr("\"m\" is not a unit of this field; one of rad, deg, mrad")));
  EXPECT_THAT(error("heading: h"), HasSubstr("its unit is missing: heading_rad, or { column: …, unit: rad }"));
  EXPECT_THAT(error("heading: { column: h }"), HasSubstr("its unit is missing"));
  EXPECT_THAT(error("heading_grad: h"), HasSubstr("has no field \"heading_grad\"; did you mean \"heading_rad\"?"));
  EXPECT_THAT(error("heading_deg: h, heading_rad: h"), HasSubstr("give either heading_deg or heading_rad"));
  EXPECT_THAT(error("heading_deg: { column: h, unit: deg }"), HasSubstr("heading_deg names the unit already"));
  EXPECT_THAT(construction_error<ConfigError>(entry(
                  "payload: GnssFix, columns: { latitude_deg: h, longitude_deg: h, hdop: { column: h, unit: m } }")),
              HasSubstr("has no unit"));
}

TEST_F(CsvUnits, AConstantStandsForAColumnThatTheFileLacks) {
  write("a.csv", "t,w\n0,0.5\n1,\n");
  const auto sample =
      first("payload: ImuSample, columns: { w_x_radps: { constant: 0 }, w_y_degps: { constant: -90 }, w_z_radps: w }")
          .as<ImuSample>();
  EXPECT_EQ(sample.w_sensor, Eigen::Vector3d(0.0, -0.5 * std::numbers::pi, 0.5));
  const auto fix = first(
                       "payload: GnssFix, columns: { east_m: w, north_m: { constant: 7 }, satellites: { constant: 9 },"
                       " sigma_horizontal_m: { constant: 0.3 }, type: { constant: rtk_float } }")
                       .as<GnssFix>();
  EXPECT_EQ(fix.p_map_antenna.y(), 7.0);
  EXPECT_EQ(fix.satellites, 9);
  EXPECT_EQ(fix.sigma_horizontal_m, 0.3);
  EXPECT_EQ(fix.type, GnssFix::Type::rtk_float);
}

TEST_F(CsvUnits, AMissingColumnIsAnsweredWithTheConstant) {
  write("a.csv", "t,w\n0,0.5\n");
  EXPECT_THAT(construction_error<ConfigError>(entry("payload: ImuSample, columns: { w_z_radps: w }")),
              HasSubstr("ImuSample needs the column \"w_x_radps\", or { constant: … } where the file has none"));
}

TEST_F(CsvUnits, AConstantThatTheFieldForbidsIsRefusedAtOnce) {
  write("a.csv", "t,w\n0,0.5\n");
  const auto error = [this](const std::string& more) { return construction_error<ConfigError>(entry(more)); };
  EXPECT_THAT(error("payload: GnssFix, columns: { latitude_deg: { constant: 91 }, longitude_deg: w }"),
              HasSubstr("91 is not a latitude (-90 to 90 deg)"));
  EXPECT_THAT(error("payload: GnssFix, columns: { east_m: w, north_m: w, type: { constant: fixed } }"),
              HasSubstr("\"fixed\" is not one of: none, single"));
  EXPECT_THAT(error("payload: Height, columns: { height_m: { constant: 1, column: w } }"), HasSubstr("column"));
}

TEST_F(CsvUnits, TwoSensorsMayDifferInAConstantOnly) {
  write("a.csv", "t,w\n0,0.5\n");
  const auto entry = [](const std::string& sensor, const std::string& value) {
    return "  - { path: a.csv, sensor: " + sensor +
           ", time: t, payload: BodyTwist, columns: { v_x_mps: w, w_z_radps: { constant: " + value + " } } }\n";
  };
  EXPECT_NO_THROW(make("files:\n" + entry("wheels", "0") + entry("other", "1")));
  EXPECT_THAT(construction_error<ConfigError>("files:\n" + entry("wheels", "0") + entry("other", "0")),
              HasSubstr("two sensors on one input"));
}

}  // namespace
}  // namespace waymark
