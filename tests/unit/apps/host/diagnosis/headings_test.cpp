// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, compass
// Headings of a compass that iron, or its noise, makes wrong.
#include <gmock/gmock.h>

#include <cmath>

#include "tests/unit/apps/host/diagnosis/curving_robot.hpp"

namespace waymark::host {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double kDegree = M_PI / 180.0;
const Drive kTurning{.turns = 3.0};  // headings all round

TEST(HeadingDiagnosis, NamesACompassBesideIron) {
  for (const double times : {1.0, 2.0}) {
    const Examined examined = examine(
        [times](Readings& r) { r.compass.heading_rad += 20.0 * kDegree * std::sin(times * r.compass.heading_rad); },
        kTurning);
    ASSERT_THAT(examined.findings, SizeIs(1));
    EXPECT_EQ(examined.findings.front().sensors.front(), "compass");
    EXPECT_EQ(examined.findings.front().check, "deviation");
    EXPECT_THAT(examined.findings.front().seen, HasSubstr(times == 1.0 ? "once per turn" : "twice per turn"));
    EXPECT_NEAR(number_after("by up to ", examined.findings.front().seen), 20.0, 3.0);
  }
}

TEST(HeadingDiagnosis, ADeviationOfFiveDegreesIsUsual) {
  const auto mistake = [](Readings& r) { r.compass.heading_rad += 5.0 * kDegree * std::sin(r.compass.heading_rad); };
  EXPECT_THAT(examine(mistake, kTurning).findings, IsEmpty());
}

TEST(HeadingDiagnosis, NamesACompassThatClaimsLessNoiseThanItHas) {
  Drive drive = kTurning;
  drive.yaml.replace(drive.yaml.find("plugin: compass,"), 16, "plugin: compass, sigma_deg: 0.15, ");
  const Examined examined = examine([](Readings&) {}, drive);
  ASSERT_THAT(examined.findings, SizeIs(1));
  EXPECT_EQ(examined.findings.front().check, "noise");
  EXPECT_NEAR(number_after("scatters by ", examined.findings.front().seen), 0.02 / kDegree, 0.4);
}

TEST(HeadingDiagnosis, NamesRadiansThatAreTakenForDegrees) {
  const auto in_radians = [](Readings& r) {
    const double heading = r.compass.heading_rad;
    r.compass.heading_rad = (heading < 0.0 ? heading + 2.0 * M_PI : heading) * kDegree;
  };
  const Examined examined = examine(in_radians, kTurning);
  EXPECT_THAT(examined.named(), testing::ElementsAre("compass"));
  ASSERT_THAT(examined.findings, SizeIs(1));
  EXPECT_EQ(examined.findings.front().check, "unit");
}

/// A robot without wheels that points beside its path by an angle [rad], which changes with time.
Examined examine_beside_path(double (*beside)(double t)) {
  Drive drive{.turns = 0.5};
  drive.yaml.replace(drive.yaml.find("name: wheels"), 6, "enabled: false, name: ");
  return examine(
      [beside](Readings& r) {
        r.compass.heading_rad = std::remainder(r.compass.heading_rad - beside(r.t), 2.0 * M_PI);
        r.imu.w_sensor.z() += (beside(r.t + 0.01) - beside(r.t - 0.01)) / 0.02;
      },
      drive);
}

TEST(HeadingDiagnosis, WhatFliesNeedNotPointWhereItGoes) {
  const auto crabwise = [](double t) { return (40.0 + 35.0 * std::sin(0.06 * t)) * kDegree; };
  EXPECT_THAT(examine_beside_path(crabwise).findings, IsEmpty());
}

TEST(HeadingDiagnosis, NamesACompassThatIsTurnedOnWhatFlies) {
  const Examined examined = examine_beside_path([](double) { return 40.0 * kDegree; });
  ASSERT_THAT(examined.findings, SizeIs(1));
  EXPECT_EQ(examined.findings.front().check, "heading");
}

}  // namespace
}  // namespace waymark::host
