// SPDX-License-Identifier: Apache-2.0
// needs plugins: gpsd
// What becomes of the lines that gpsd 3.22 wrote for a u-blox ZED-F9P, and of changed ones.
#include "plugins/sources/gpsd/epoch_reports.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <string>

namespace waymark::gpsd {
namespace {

using GnssType = GnssFix::Type;

constexpr const char* kVersion =
    R"({"class":"VERSION","release":"3.22","rev":"3.22","proto_major":3,"proto_minor":14})";

std::string tpv(const std::string& time, const std::string& more = "", int mode = 3) {
  return R"({"class":"TPV","device":"/dev/pts/1","mode":)" + std::to_string(mode) +
         (time.empty() ? "" : R"(,"time":"2019-04-12T00:39:)" + time + R"(Z","ept":0.005)") +
         R"(,"lat":-45.877567167,"lon":170.500112000,"altHAE":16.0000,"altMSL":14.2000,"alt":14.2000,"epx":3.500,)"
         R"("epy":2.300,"magvar":25.7,"speed":0.010,"track":90.0,"eph":12.160)" +
         more + "}";
}
std::string gst(const std::string& time) {
  return R"({"class":"GST","device":"/dev/pts/1",)" +
         (time.empty() ? "" : R"("time":"2019-04-12T00:39:)" + time + R"(Z",)") +
         R"("rms":43.000,"lat":3.000,"lon":4.000,"alt":5.000})";
}
Time at(const std::string& second) {
  using namespace std::chrono;
  return Time(sys_days(2019y / April / 12) + minutes(39)) + (parse_time(second) - Time{});
}

TEST(EpochReports, ReportsOfOneTimeAreOneFix) {
  EpochReports reports;
  reports.take(kVersion);
  EXPECT_EQ(reports.release(), "3.22");
  reports.take(
      R"({"class":"SKY","device":"/dev/pts/1","hdop":0.7,"nSat":3,"uSat":2,"satellites":[{"PRN":5,"el":6.0,"az":1.0,)"
      R"("ss":18.0,"used":false},{"PRN":10,"el":24.0,"az":2.0,"ss":9.0,"used":true},{"PRN":13,"el":30.0,"az":3.0,)"
      R"("ss":9.0,"used":true}]})");
  reports.take(R"({"class":"SKY","device":"/dev/pts/1","hdop":0.64,"uSat":8})");  // without a list: dilution only
  EXPECT_FALSE(reports.take(gst("58.000")));
  EXPECT_TRUE(reports.is_waiting());
  EXPECT_FALSE(reports.take(tpv("58.000")));
  EXPECT_FALSE(reports.take(tpv("58.000", R"(,"status":2)"))) << "a second report of one time";
  const auto complete = reports.take(tpv("59.000"));
  ASSERT_TRUE(complete.has_value());
  EXPECT_EQ(complete->stamp, at("58"));
  const GnssFix& fix = *complete->fix;
  EXPECT_EQ(fix.latitude_deg, -45.877567167);
  EXPECT_EQ(fix.longitude_deg, 170.500112);
  EXPECT_EQ(fix.height_m, 16.0) << "above the ellipsoid";
  EXPECT_EQ(fix.type, GnssType::differential);
  EXPECT_NEAR(fix.sigma_horizontal_m, std::sqrt(12.5), 1e-12) << "of GST";
  EXPECT_EQ(fix.sigma_vertical_m, 5.0);
  EXPECT_EQ(fix.speed_mps, 0.01);
  EXPECT_NEAR(fix.course_rad, std::numbers::pi / 2, 1e-12) << "true, without gpsd's declination";
  EXPECT_EQ(fix.hdop, 0.64);
  EXPECT_EQ(fix.satellites, 2);
}

TEST(EpochReports, SigmasMayComeBehindThePosition) {
  EpochReports reports;
  reports.take(tpv("58.000"));
  reports.take(gst("58.000"));
  const auto complete = reports.finish();
  ASSERT_TRUE(complete.has_value());
  EXPECT_EQ(complete->fix->sigma_vertical_m, 5.0);
  EXPECT_EQ(complete->fix->type, GnssType::single) << "gpsd leaves out the status of a plain fix";
}

TEST(EpochReports, GstOfAnotherTimeIsNotTaken) {
  EpochReports reports;
  reports.take(gst("57.000"));
  EXPECT_FALSE(reports.take(tpv("58.000"))) << "sigmas without a position are not a fix";
  const auto complete = reports.finish();
  ASSERT_TRUE(complete.has_value());
  EXPECT_TRUE(std::isnan(complete->fix->sigma_horizontal_m)) << "epx and epy of gpsd are not of a known confidence";
}

TEST(EpochReports, WhatComesLateForACompleteTimeIsLeftOut) {
  EpochReports reports;
  reports.take(tpv("58.000"));
  ASSERT_TRUE(reports.finish().has_value());
  EXPECT_FALSE(reports.take(tpv("58.000")));
  EXPECT_FALSE(reports.take(tpv("57.500")));
  EXPECT_FALSE(reports.finish().has_value());
}

TEST(EpochReports, AClockThatIsSetBackIsFollowed) {
  EpochReports reports;
  reports.take(tpv("58.000"));
  ASSERT_TRUE(reports.finish().has_value());
  reports.take(tpv("20.000"));
  const auto complete = reports.finish();
  ASSERT_TRUE(complete.has_value()) << "whether its stamp is plausible is for the host to judge";
  EXPECT_EQ(complete->stamp, at("20"));
}

TEST(EpochReports, NoFixAndNoTime) {
  EpochReports reports;
  EXPECT_FALSE(reports.take(tpv("")));
  EXPECT_FALSE(reports.take(gst("")));
  EXPECT_FALSE(reports.is_waiting()) << "without a time it belongs nowhere";
  reports.take(tpv("58.000", "", 1));
  const auto complete = reports.finish();
  ASSERT_TRUE(complete.has_value());
  EXPECT_EQ(complete->fix->type, GnssType::none);
  EXPECT_TRUE(std::isnan(complete->fix->latitude_deg));
}

TEST(EpochReports, AYearBeyondAllStampsIsNoTime) {
  EpochReports reports;
  for (const std::string year : {"2117", "2200", "2600", "9999"}) {
    reports.take(R"({"class":"TPV","mode":3,"time":")" + year + R"(-04-12T00:39:58.000Z","lat":45.0,"lon":8.0})");
    EXPECT_FALSE(reports.is_waiting()) << year;
  }
  reports.take(R"({"class":"TPV","mode":3,"time":"2115-04-12T00:39:58.000Z","lat":45.0,"lon":8.0})");
  EXPECT_TRUE(reports.is_waiting());
}

TEST(EpochReports, TypesFollowTheStatus) {
  const std::vector<std::pair<int, GnssType>> types{
      {1, GnssType::single}, {2, GnssType::differential}, {3, GnssType::rtk_fixed}, {4, GnssType::rtk_float},
      {5, GnssType::none},   {6, GnssType::single},       {7, GnssType::none},      {8, GnssType::unknown}};
  for (const auto& [status, type] : types) {
    EpochReports reports;
    reports.take(tpv("58.000", R"(,"status":)" + std::to_string(status)));
    EXPECT_EQ(reports.finish()->fix->type, type) << status;
  }
}

TEST(EpochReports, APlaneFixHasNoHeight) {
  EpochReports reports;
  reports.take(tpv("58.000", "", 2));
  EXPECT_TRUE(std::isnan(reports.finish()->fix->height_m));
}

TEST(EpochReports, DamagedLinesAreLeftOut) {
  EpochReports reports;
  const std::string line = tpv("58.000");
  for (std::size_t size = 0; size < line.size(); ++size) reports.take(line.substr(0, size));
  reports.take(std::string(60'000, '{'));
  reports.take("{\"class\":\"TPV\"" + std::string(60'000, ','));
  reports.take("\xff\xfe");
  // libgps 3.22 reads these without end.
  reports.take(
      R"({"class":"TPV","mode":3,"time":"2019-04-12T00:39:59.000Z","lat":-45.8,"class":"VERSION","v":"3.22"})");
  reports.take(
      R"({"class":"DEVICES","devices":[{"class":"DEVICE","path":"/dev/pts/1","bps":9600,"cycle":,"mag_st":"N"})");
  reports.take(tpv("59.000"));
  const auto complete = reports.finish();
  ASSERT_TRUE(complete.has_value());
  EXPECT_EQ(complete->stamp, at("59"));
}

}  // namespace
}  // namespace waymark::gpsd
