// SPDX-License-Identifier: Apache-2.0
#include "earth_field.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "waymark/base/error.hpp"

namespace waymark::magnetic_model {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

Time on(int year, unsigned month, unsigned day) {
  return std::chrono::sys_days(std::chrono::year(year) / static_cast<int>(month) / static_cast<int>(day));
}

EarthField by_model() { return EarthField(Config::parse("{ declination: auto }")); }

// The model's own report (NOAA, 2024) has these test values for 2025.0 at height 0.
struct Published {
  double latitude, longitude, declination, dip, strength_nt;
};

TEST(EarthField, GivesTheModelsPublishedTestValues) {
  for (const Published& p : {Published{80.0, 0.0, 1.28, 83.21, 55178.5}, Published{0.0, 120.0, -0.16, -14.93, 41064.3},
                             Published{-80.0, 240.0, 68.78, -72.00, 54698.2}}) {
    const Datum place{p.latitude, p.longitude, 0.0};
    const Field field = by_model().at(on(2025, 1, 1), &place);
    EXPECT_NEAR(field.declination / kDegree, p.declination, 0.005);
    EXPECT_NEAR(*field.dip / kDegree, p.dip, 0.005);
    EXPECT_NEAR(*field.strength_t * 1e9, p.strength_nt, 0.06);
  }
}

TEST(EarthField, FollowsTheDate) {
  const Datum karlsruhe{49.0157, 8.4258, 115.0};
  EarthField earth = by_model();
  const double first = earth.at(on(2025, 1, 1), &karlsruhe).declination;
  const double last = earth.at(on(2029, 1, 1), &karlsruhe).declination;
  EXPECT_NEAR(first / kDegree, 3.44, 0.01);
  EXPECT_GT(last - first, 0.3 * kDegree);
  EXPECT_EQ(earth.at(on(2025, 1, 1), &karlsruhe).declination, first);
}

TEST(EarthField, FollowsThePlace) {
  EarthField earth = by_model();
  const Datum here{49.0, 8.4, 0.0};
  const Datum there{-80.0, 240.0, 0.0};
  EXPECT_LT(earth.at(on(2026, 3, 1), &here).declination, 10.0 * kDegree);
  EXPECT_GT(earth.at(on(2026, 3, 1), &there).declination, 60.0 * kDegree);
}

TEST(EarthField, RefusesADateOutOfItsTimeAndSaysWhatToDo) {
  const Datum place{49.0, 8.4, 0.0};
  EarthField earth = by_model();
  for (const Time stamp : {on(2013, 6, 1), on(2030, 3, 1), Time{}}) {
    try {
      earth.at(stamp, &place);
      FAIL() << "not refused";
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(),
                  AllOf(HasSubstr("from 2025.0 to 2030.0"), HasSubstr("declination_deg"), HasSubstr("magnetic_model")));
    }
  }
}

TEST(EarthField, NeedsThePlaceOnlyForTheModel) {
  EXPECT_THROW(by_model().at(on(2025, 6, 1), nullptr), DataError);
  EarthField given(Config::parse("{ declination_deg: -4 }"));
  const Field field = given.at(on(1999, 1, 1), nullptr);
  EXPECT_NEAR(field.declination, -4.0 * kDegree, 1e-15);
  EXPECT_FALSE(field.strength_t || field.dip);
}

std::string refusal(const std::string& yaml) {
  try {
    EarthField{Config::parse(yaml)};
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(EarthField, RefusesMissingDoubleOrUnknownWords) {
  EXPECT_THAT(refusal("{ name: compass }"), AllOf(HasSubstr("text:1:"), HasSubstr("declination_deg")));
  EXPECT_THAT(refusal("{ declination: auto, declination_deg: 3 }"), HasSubstr("text:1:"));
  EXPECT_THAT(refusal("{ declination: east }"), HasSubstr("auto"));
  EXPECT_NEAR(EarthField(Config::parse("{ name: imu }"), 2.0).at(Time{}, nullptr).declination, 2.0 * kDegree, 1e-15);
}

TEST(EarthField, RefusesAFileThatIsNoModel) {
  EXPECT_THAT(refusal("{ declination: auto, magnetic_model: /nowhere/wmm2030.wmm }"),
              AllOf(HasSubstr("magnetic_model"), HasSubstr("/nowhere/wmm2030.wmm")));
}

TEST(EarthField, TheFolderCanBeNamed) {
  ::setenv("WAYMARK_MAGNETIC_MODEL", WAYMARK_SOURCE_DIR "/sensors/shared/magnetic_model/data", 1);
  EXPECT_TRUE(by_model().uses_model());
  ::unsetenv("WAYMARK_MAGNETIC_MODEL");
  EXPECT_TRUE(EarthField(Config::parse("{ declination: auto, magnetic_model: " WAYMARK_SOURCE_DIR
                                       "/sensors/shared/magnetic_model/data/wmm2025.wmm }"))
                  .uses_model());
}

TEST(DecimalYear, CountsLeapYears) {
  EXPECT_EQ(decimal_year(on(2025, 1, 1)), 2025.0);
  EXPECT_NEAR(decimal_year(on(2028, 3, 1)), 2028.0 + 60.0 / 366.0, 1e-12);
  EXPECT_NEAR(decimal_year(on(2025, 3, 1)), 2025.0 + 59.0 / 365.0, 1e-12);
}

}  // namespace
}  // namespace waymark::magnetic_model
