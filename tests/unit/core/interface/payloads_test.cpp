// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/payloads.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "waymark/interface/payload_description.hpp"

namespace waymark {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

template <class Visit>
void for_each_core_payload(Visit&& visit) {
  std::apply([&](const auto&... payload) { (visit(payload), ...); }, CorePayloads());
}

template <class T>
std::string section_of(const T&) {
  std::string text = "\n## " + std::string(short_type_name(T::kType)) + "\n\n`" + std::string(T::kType) +
                     "`\n\n| Field | Kind | Unit | Meaning | Required | If not known |\n|---|---|---|---|---|---|\n";
  for (const FieldDescription& field : describe_fields<T>()) {
    text += "| `" + field.name + "` | " + field.kind + " | " + std::string(field.info.unit) + " | " +
            std::string(field.info.meaning) + " | " + (field.info.required ? "yes" : "no") + " | " +
            std::string(field.info.unknown) + " |\n";
  }
  return text;
}

std::string page() {
  std::string text =
      "# Payloads\n\nThe payloads exchanged between sources, sensors and maps. Generated from the fields that "
      "[payloads.hpp](../core/include/waymark/interface/payloads.hpp) registers; a test compares them.\nA text format "
      "must contain every required field. A value is finite, or it is the one that means \"not known\".\n";
  for_each_core_payload([&](const auto& payload) { text += section_of(payload); });
  return text;
}

TEST(Payloads, ThePageListsTheRegisteredFields) {
  std::ifstream file(WAYMARK_SOURCE_DIR "/docs/payloads.md");
  std::stringstream committed;
  committed << file.rdbuf();
  EXPECT_TRUE(committed.str() == page()) << "docs/payloads.md should be:\n" << page();
}

TEST(Payloads, EveryFieldHasANameOfItsOwnAndAMeaning) {
  for_each_core_payload([]<class T>(const T&) {
    std::set<std::string> names;
    for (const FieldDescription& field : describe_fields<T>()) {
      EXPECT_TRUE(names.insert(field.name).second) << T::kType << ' ' << field.name;
      EXPECT_FALSE(field.info.meaning.empty()) << T::kType << ' ' << field.name;
    }
    EXPECT_FALSE(names.empty()) << T::kType;
  });
}

struct Listed final : FieldVisitor {
  void field(const FieldInfo& info, const FieldValue& value) override {
    std::string text(info.name());
    if (const auto* numbers = std::get_if<std::span<const double>>(&value)) {
      for (const double number : *numbers) text += " " + std::to_string(std::lround(number));
    } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
      text += " " + std::to_string(*integer);
    } else if (const auto* word = std::get_if<FieldWord>(&value)) {
      text += " " + std::string(word->word);
    }
    all.push_back(text);
  }
  void list(const FieldInfo& info, std::size_t size) override {
    all.push_back(std::string(info.name()) + ": " + std::to_string(size));
  }
  std::vector<std::string> all;
};

TEST(Payloads, AVisitorReadsEveryValue) {
  GnssFix fix;
  fix.p_map_antenna = {1.0, 2.0, 3.0};
  fix.latitude_deg = fix.longitude_deg = fix.height_m = fix.sigma_horizontal_m = fix.sigma_vertical_m = 4.0;
  fix.hdop = fix.speed_mps = fix.course_rad = 5.0;
  fix.satellites = 6;
  fix.type = GnssFix::Type::rtk_fixed;
  Listed listed;
  EXPECT_TRUE(fix.visit(listed));
  EXPECT_THAT(listed.all, ElementsAre("east_m 1 2 3", "latitude_deg 4", "longitude_deg 4", "height_m 4",
                                      "sigma_horizontal_m 4", "sigma_vertical_m 4", "hdop 5", "satellites 6",
                                      "type rtk_fixed", "speed_mps 5", "course_rad 5"));
}

TEST(Payloads, AVisitorReadsTheFieldsOfAList) {
  LandmarkObservations seen;
  seen.landmarks = {{1.0, 2.0, 3.0, 4}, {5.0, 6.0, 7.0, 8}};
  Listed listed;
  seen.visit(listed);
  EXPECT_THAT(listed.all, ElementsAre("landmarks: 2", "range_m 1", "bearing_rad 2", "radius_m 3", "identity 4",
                                      "range_m 5", "bearing_rad 6", "radius_m 7", "identity 8"));
}

TEST(Payloads, WhatMayBeUnknownIsNotAProblem) {
  GnssFix fix;
  fix.p_map_antenna.head<2>() << 1.0, 2.0;
  EXPECT_THAT(fix.problem(), IsEmpty());
  ImuSample sample;
  sample.w_sensor.setZero();
  EXPECT_THAT(sample.problem(), IsEmpty());
  LaserScan scan;
  scan.step_rad = 0.1;
  scan.ranges_m = {1.0f, std::numeric_limits<float>::infinity()};
  EXPECT_THAT(scan.problem(), IsEmpty());
}

TEST(Payloads, AProblemNamesItsField) {
  WheelSpeeds wheels;
  wheels.right_mps = kNaN;
  EXPECT_EQ(wheels.problem(), "right_mps is not finite");
  Height height;
  height.sigma_m = kInfinite;
  EXPECT_EQ(height.problem(), "sigma_m is not finite");
  MagneticField field;
  field.m_sensor.z() = kNaN;
  EXPECT_EQ(field.problem(), "m_z_t is not finite");
  GnssFix fix;
  fix.latitude_deg = 91.0;
  fix.longitude_deg = 8.0;
  EXPECT_EQ(fix.problem(), "latitude_deg is beyond ±90");
  LandmarkObservations seen;
  seen.landmarks = {{1.0, 2.0}, {1.0, kNaN}};
  EXPECT_EQ(seen.problem(), "bearing_rad is not finite");
  PointCloud cloud;
  cloud.points_m = {Eigen::Vector3f(0.0f, 0.0f, std::nanf(""))};
  EXPECT_EQ(cloud.problem(), "a point of points_m is not finite");
  cloud.points_m.front().setZero();
  cloud.offsets_s = {std::nanf("")};
  EXPECT_EQ(cloud.problem(), "a value of offsets_s is not finite");
}

TEST(Payloads, AProblemCanBeWithSeveralFieldsTogether) {
  PoseIncrement increment;
  EXPECT_THAT(increment.problem(), HasSubstr("interval"));
  EXPECT_THAT(GnssFix().problem(), HasSubstr("neither east and north nor latitude and longitude"));
  ImuSample sample;
  sample.w_sensor << 0.0, kNaN, 0.0;
  EXPECT_THAT(sample.problem(), HasSubstr("neither finite nor unknown"));
  sample.w_sensor.setZero();
  sample.q_enu_sensor.coeffs().setConstant(0.7);
  EXPECT_THAT(sample.problem(), HasSubstr("unit quaternion"));
  LaserScan scan;
  EXPECT_THAT(scan.problem(), HasSubstr("step"));
  scan.step_rad = 0.1;
  EXPECT_THAT(scan.problem(), HasSubstr("without beams"));
  scan.ranges_m = {-1.0f};
  EXPECT_THAT(scan.problem(), HasSubstr("negative or NaN"));
  scan.ranges_m = {1.0f};
  scan.intensities = {1.0f, 2.0f};
  EXPECT_THAT(scan.problem(), HasSubstr("as many intensities"));
  PointCloud cloud;
  cloud.offsets_s = {0.0f};
  EXPECT_THAT(cloud.problem(), HasSubstr("as many offsets"));
  LandmarkObservations seen;
  seen.landmarks = {{-1.0, 2.0}};
  EXPECT_THAT(seen.problem(), HasSubstr("negative"));
  Ranges ranges;
  ranges.ranges = {{.beacon = 1, .range_m = -1.0, .reference = 2}};
  EXPECT_THAT(ranges.problem(), IsEmpty());
  ranges.ranges.front().reference = 1;
  EXPECT_THAT(ranges.problem(), HasSubstr("its own reference"));
  ranges.ranges.front().reference = -1;
  EXPECT_THAT(ranges.problem(), HasSubstr("a range is negative"));
  ranges.ranges = {{.range_m = 1.0}};
  EXPECT_THAT(ranges.problem(), HasSubstr("number is negative"));
  RadarTargets targets;
  targets.targets = {{.range_m = -1.0}};
  EXPECT_THAT(targets.problem(), HasSubstr("negative"));
}

/// As a plugin would bring it.
struct Opaque : PayloadOf<Opaque> {
  static constexpr std::string_view kType = "test/Opaque@1";
  double value = kNaN;
};
struct Registered : PayloadOf<Registered> {
  static constexpr std::string_view kType = "test/Registered@2";
  double value = 1.0;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Registered::value, {.names = {"value"}});
  }
  std::string_view contradiction() const { return value < 0.0 ? "it is negative" : ""; }
};

TEST(Payloads, ThoseOfPluginsMayRegisterTheirFields) {
  Listed listed;
  EXPECT_FALSE(Opaque().visit(listed));
  EXPECT_THAT(Opaque().problem(), IsEmpty());
  Registered registered;
  EXPECT_TRUE(registered.visit(listed));
  EXPECT_THAT(listed.all, ElementsAre("value 1"));
  registered.value = -1.0;
  EXPECT_EQ(registered.problem(), "it is negative");
  registered.value = kNaN;
  EXPECT_EQ(registered.problem(), "value is not finite");
  EXPECT_EQ(short_type_name(registered.type()), "Registered");
}

TEST(Payloads, ABeamEndsAtItsRangeInItsDirection) {
  LaserScan scan;
  scan.start_rad = -M_PI / 2.0;
  scan.step_rad = M_PI / 4.0;
  scan.ranges_m = {1.0f, 2.0f, 3.0f};
  EXPECT_TRUE(scan.p_sensor_end(0).isApprox(Eigen::Vector3d(0.0, -1.0, 0.0)));
  EXPECT_TRUE(scan.p_sensor_end(1).isApprox(Eigen::Vector3d(std::sqrt(2.0), -std::sqrt(2.0), 0.0)));
  EXPECT_TRUE(scan.p_sensor_end(2).isApprox(Eigen::Vector3d(3.0, 0.0, 0.0)));
}

}  // namespace
}  // namespace waymark
