// SPDX-License-Identifier: Apache-2.0
// How the source nmea reads sentences, their times, and lines that are none.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <thread>

#include "source_error.hpp"
#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// With the dollar sign, the checksum and the end of the line.
std::string line(const std::string& body, const std::string& end = "\r\n") {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return fmt::format("${}*{:02X}{}", body, sum, end);
}

std::string gga(const std::string& time, const std::string& quality = "1", const std::string& latitude = "4930.0000") {
  return line("GPGGA," + time + "," + latitude + ",N,00830.6000,E," + quality + ",08,1.5,100.0,M,47.5,M,,");
}
std::string rmc(const std::string& time, const std::string& date, const std::string& status = "A") {
  return line("GPRMC," + time + "," + status + ",4930.0000,N,00830.6000,W,10.0,90.0," + date + ",,,A");
}

class Nmea : public ::testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(folder_ / "log.nmea", std::ios::binary) << text; }
  std::shared_ptr<Source> make(const std::string& more = "") const {
    const std::string yaml = "file: log.nmea\ngnss: { sensor: gps }\n" + more;
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    auto source = PluginLoader({WAYMARK_PLUGIN_DIR})
                      .create<Source>("nmea", config, Rig({{"gps", "", std::nullopt}, {"compass", "", std::nullopt}}));
    config.reject_unread();
    return source;
  }
  std::vector<Measurement> read(const std::string& text, const std::string& more = "") {
    write(text);
    const auto source = make(more);
    std::vector<Measurement> all;
    while (auto m = source->next()) all.push_back(std::move(*m));
    bad_.clear();
    for (const BadRecord& record : source->bad_records()) bad_.push_back(record.place + ": " + record.reason);
    return all;
  }
  static std::vector<double> seconds(const std::vector<Measurement>& all) {
    std::vector<double> times;
    for (const Measurement& m : all)
      times.push_back(static_cast<double>(m.stamp.time_since_epoch().count() / 1'000'000) / 1e3);
    return times;
  }
  template <class E>
  std::string error_of(const std::string& more) const {
    return test::source_error<E>([&] { return make(more); });
  }

  test::TemporaryFolder folder_;
  std::vector<std::string> bad_;
};

TEST_F(Nmea, SentencesOfOneEpochAreOneFix) {
  const auto all =
      read(gga("120000.25", "4") + line("GNGST,120000.25,1.0,,,,0.3,0.4,0.9") + rmc("120000.25", "311224") +
           line("GPVTG,45.0,T,,M,99.0,N,183.3,K,A") + gga("120001.25", "5") + "# the end\n");
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[0].stamp.time_since_epoch().count(), 1'735'646'400'250'000'000);
  EXPECT_EQ(all[0].arrival, all[0].stamp);
  const auto& fix = all[0].as<GnssFix>();
  EXPECT_EQ(fix.latitude_deg, 49.5);
  EXPECT_EQ(fix.longitude_deg, 8.51);
  EXPECT_EQ(fix.height_m, 147.5);
  EXPECT_EQ(fix.hdop, 1.5);
  EXPECT_EQ(fix.satellites, 8);
  EXPECT_EQ(fix.type, GnssFix::Type::rtk_fixed);
  EXPECT_NEAR(fix.sigma_horizontal_m, 0.25 * std::sqrt(2.0), 1e-12);
  EXPECT_EQ(fix.sigma_vertical_m, 0.9);
  EXPECT_NEAR(fix.speed_mps, 5.14444, 1e-5);
  EXPECT_NEAR(fix.course_rad, 90.0 * kRadPerDeg, 1e-12);
  const auto& next = all[1].as<GnssFix>();
  EXPECT_EQ(next.type, GnssFix::Type::rtk_float);
  EXPECT_TRUE(std::isnan(next.sigma_horizontal_m) && std::isnan(next.speed_mps));
  EXPECT_THAT(bad_, IsEmpty());
}

TEST_F(Nmea, VtgTellsWhatRmcLeavesOut) {
  const auto all =
      read(line("GPRMC,120000,A,4930.0,N,00830.0,E,5.0,,311224,,,A") + line("GPVTG,90.0,T,,M,10.0,N,18.5,K,A") +
           line("GPGGA,120000,4930.0,N,00830.0,E,1,8,1.0,100.0,M,50.0,M,,"));
  const auto& fix = all.at(0).as<GnssFix>();
  EXPECT_NEAR(fix.speed_mps, 5.0 * 0.514444, 1e-5) << "of RMC, which has it";
  EXPECT_NEAR(fix.course_rad, 90.0 * kRadPerDeg, 1e-12);
}

TEST_F(Nmea, WhatIsEmptyIsUnknown) {
  const auto all = read(line("GNGGA,120000,4930.0,S,00830.0,W,2,,,100.0,M,,,,") + line("GNVTG,,T,,M,,N,36.0,K,D") +
                            line("GNGST,120000,,5.0,1.0,10,,,"),
                        "start_date: 2024-12-31\n");
  const auto& fix = all.at(0).as<GnssFix>();
  EXPECT_EQ(fix.latitude_deg, -49.5);
  EXPECT_EQ(fix.longitude_deg, -8.5);
  EXPECT_TRUE(std::isnan(fix.height_m)) << "a height above the geoid is none above the ellipsoid";
  EXPECT_TRUE(std::isnan(fix.hdop) && std::isnan(fix.course_rad) && std::isnan(fix.sigma_vertical_m));
  EXPECT_EQ(fix.satellites, -1);
  EXPECT_EQ(fix.type, GnssFix::Type::differential);
  EXPECT_NEAR(fix.speed_mps, 10.0, 1e-12);
  EXPECT_NEAR(fix.sigma_horizontal_m, std::sqrt(13.0), 1e-12) << "the ellipse, if there is no more";
}

TEST_F(Nmea, OtherSentencesGiveAPositionToo) {
  const auto all =
      read(rmc("120000", "010125") + line("GPGLL,4931.2,N,00830.0,E,120001,A,D") + line("GPGLL,,,,,120002,V,N"));
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0].as<GnssFix>().longitude_deg, -8.51);
  EXPECT_EQ(all[0].as<GnssFix>().type, GnssFix::Type::single);
  EXPECT_EQ(all[1].as<GnssFix>().latitude_deg, 49.52);
  EXPECT_EQ(all[1].as<GnssFix>().type, GnssFix::Type::differential);
  EXPECT_EQ(all[2].as<GnssFix>().type, GnssFix::Type::none);
}

TEST_F(Nmea, NoFixIsToldAfterTheFirstFix) {
  const auto all = read(rmc("115958", "010125", "V") + gga("115958", "0") + gga("120000") +
                        gga("120001", "0", "8960.0000") + gga("120002"));
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[1].as<GnssFix>().type, GnssFix::Type::none);
  EXPECT_TRUE(std::isnan(all[1].as<GnssFix>().latitude_deg));
  EXPECT_THAT(bad_, IsEmpty());
}

TEST_F(Nmea, OneFixToldTwiceIsOne) {
  const auto all =
      read(line("GLGGA,120000,,,,,0,,,,M,,M,,") + gga("120000") + gga("120000", "2"), "start_date: 2025-01-01\n");
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].as<GnssFix>().type, GnssFix::Type::single);
}

TEST_F(Nmea, HeadingsBelongToTheEpochBeforeThemOrTheNext) {
  const std::string text = line("HEHDT,10.0,T") + rmc("120000", "010125") + line("HEHDT,20.0,T") + gga("120001") +
                           line("HEHDT,30.0,T") + line("HEHDT,,T");
  const auto headings = [](const std::vector<Measurement>& all) {
    std::vector<double> degrees;
    for (const Measurement& m : all) {
      if (m.sensor == 1) degrees.push_back(std::round(m.as<CompassHeading>().heading_rad / kRadPerDeg));
    }
    return degrees;
  };
  const auto previous = read(text, "heading: { sensor: compass }\n");
  EXPECT_THAT(headings(previous), ElementsAre(20, 30));
  EXPECT_TRUE(previous.at(1).as<CompassHeading>().from_true_north);
  EXPECT_EQ(previous.at(1).stamp, previous.at(0).stamp);
  EXPECT_THAT(headings(read(text, "heading: { sensor: compass, time: next }\n")), ElementsAre(10, 20));
}

TEST_F(Nmea, MidnightPasses) {
  const auto all =
      read(rmc("235959.5", "311224") + gga("235959.9") + gga("000000.1") + gga("000001") + rmc("000002", "010125"));
  EXPECT_THAT(seconds(all), ElementsAre(1735689599.5, 1735689599.9, 1735689600.1, 1735689601.0, 1735689602.0));
}

TEST_F(Nmea, AFixBeforeTheFirstDateIsCounted) {
  const auto all = read(gga("120000") + gga("120001", "0") + rmc("120002", "010125"));
  EXPECT_THAT(all, SizeIs(1));
  ASSERT_THAT(bad_, SizeIs(1));
  EXPECT_THAT(bad_[0], AllOf(HasSubstr("log.nmea:1: a fix has no date"), HasSubstr("start_date")));
  write(gga("120000"));
  EXPECT_THAT(seconds(read(gga("120000"), "start_date: 2025-01-01\n")), ElementsAre(1735732800.0));
}

TEST_F(Nmea, AStartUpClockIsANamedFault) {
  const auto all = read(rmc("235959", "050180", "V") + rmc("000001", "060180", "V") + rmc("120000", "010125", "V") +
                        rmc("120001", "010125"));
  EXPECT_THAT(seconds(all), ElementsAre(1735732801.0));
  ASSERT_THAT(bad_, SizeIs(1));
  EXPECT_THAT(bad_[0], AllOf(HasSubstr("log.nmea:3: time jumps forward by"), HasSubstr("from 1980-01-06 00:00:01.000"),
                             HasSubstr("the receiver's clock was not set yet")));
}

TEST_F(Nmea, TimeNeitherGoesBackNorJumps) {
  const auto all = read(rmc("120000", "010125") + gga("115959") + gga("120000.5") + gga("140000") + gga("140001") +
                        rmc("140002", "010100"));
  EXPECT_THAT(seconds(all), ElementsAre(1735732800.0, 1735732800.5, 1735740001.0));
  ASSERT_THAT(bad_, SizeIs(3));
  EXPECT_THAT(bad_[0], HasSubstr("time goes back by 1.000 s, from 2025-01-01 12:00:00.000 to 2025-01-01 11:59:59.000"));
  EXPECT_THAT(bad_[1], HasSubstr("time jumps forward by 7199.500 s"));
  EXPECT_THAT(bad_[2], HasSubstr("time goes back by"));
  EXPECT_THAT(read(rmc("120000", "010125") + gga("120500"), "max_time_jump_s: 60\n"), SizeIs(1));
}

TEST_F(Nmea, AYearThatNoStampHasIsABadRecord) {
  const std::string beyond = line("GPZDA,120000,31,12,2199,00,00") + gga("120000");
  EXPECT_THAT(read(beyond + rmc("120001", "010125")), SizeIs(1));
  ASSERT_THAT(bad_, SizeIs(1));
  EXPECT_THAT(bad_[0], HasSubstr("the year 2199 is not a year of a stamp"));
  EXPECT_THROW(read(rmc("120001", "010125"), "start_date: 2300-01-01\n"), ConfigError);
  EXPECT_THROW(read(rmc("120001", "010125"), "start_date: 1700-01-01\n"), ConfigError);
}

TEST_F(Nmea, LinesMayEndInAnyWay) {
  const std::string text = "\n\r\n# comment\r\n!AIVDM,1,1,,A,x,0*00\n$PUBX,00*00\r\n" + rmc("120000", "010125") +
                           line("GPGGA,120001,4930.0,N,00830.0,E,1,,,,,,,,", "\n") +
                           line("GPGGA,120002,4930.0,N,00830.0,E,1,,,,,,,,", "\r") +
                           line("GPGGA,120003,4930.0,N,00830.0,E,1,,,,,,,,", "");
  EXPECT_THAT(read(text), SizeIs(4));
  EXPECT_THAT(bad_, IsEmpty());
}

TEST_F(Nmea, LinesThatAreNoSentencesAreCounted) {
  std::string wrong = gga("120001");
  wrong[10] = '9';
  read(rmc("120000", "010125") + wrong + "hello\n" + "$GPGGA,120002,4930.0,N,00830.0,E,1,,,,,,,,\n" +
       line("GPGGA,120003,49x0.0,N,00830.0,E,1,,,,,,,,") + line("GPGGA,126003,4930.0,N,00830.0,E,1,,,,,,,,") +
       line("GPRMC,120004,A,4930.0,N,00830.0,E,1,2,310225,,,A") + line("GPGGA,120005,,,,,1,,,,,,,,") + line("A,1") +
       line("GPGGA,120006,4930.0,N,00830.0,E,1,08,x,,,,,,") + line("GPGGA,120007,9100.0,N,00830.0,E,1,,,,,,,,") +
       std::string(5000, '$') + "\n");
  std::string all;
  for (const std::string& record : bad_) all += record + "\n";
  EXPECT_THAT(bad_, SizeIs(11));
  EXPECT_THAT(all, HasSubstr("log.nmea:2: \"GPGGA,120901"));
  EXPECT_THAT(all, HasSubstr("is right"));
  EXPECT_THAT(all, HasSubstr("log.nmea:3: \"hello\" is not a sentence"));
  EXPECT_THAT(all, HasSubstr("log.nmea:4: \"GPGGA,120002,4930.0,N,00830.0,E,1,,,,,,,\" has no checksum"));
  EXPECT_THAT(all, HasSubstr("log.nmea:5: GGA: fields 2 and 3 are \"49x0.0\" and \"N\""));
  EXPECT_THAT(all, HasSubstr("log.nmea:6: GGA: field 1 is \"126003\", a time"));
  EXPECT_THAT(all, HasSubstr("log.nmea:7: RMC: field 9 is \"310225\", a date"));
  EXPECT_THAT(all, HasSubstr("log.nmea:8: the receiver reports a fix, but not where"));
  EXPECT_THAT(all, HasSubstr("log.nmea:10: GGA: field 8 is \"x\", a number"));
  EXPECT_THAT(all, HasSubstr("log.nmea:12: a line of 1000 characters"));
  EXPECT_THAT(error_of<DataError>("max_bad_records: 2\n"), HasSubstr("max_bad_records allows 2"));
  EXPECT_THAT(read("$GPGGA,120002,4930.0,N,00830.0,E,1,,,,,,,,\n", "require_checksum: false\nstart_date: 2025-01-01\n"),
              SizeIs(1));
}

TEST_F(Nmea, TheYamlMustMakeSense) {
  write("");
  EXPECT_THAT(error_of<ConfigError>("start_date: 2025-02-30\n"), HasSubstr("is not a date as 2024-12-31"));
  EXPECT_THAT(error_of<ConfigError>("heading: { sensor: x }\n"), HasSubstr("there is no sensor \"x\""));
  EXPECT_THAT(error_of<ConfigError>("heading: { sensor: compass, times: next }\n"),
              HasSubstr("did you mean \"time\"?"));
  std::filesystem::remove(folder_ / "log.nmea");
  EXPECT_THAT(error_of<ConfigError>(""), HasSubstr("log.nmea cannot be read: No such file"));
}

TEST_F(Nmea, AStreamIsReadAsItComes) {
  ASSERT_EQ(::mkfifo((folder_ / "log.nmea").c_str(), 0600), 0);
  const auto source = make("delay_s: 0.25\n");
  std::thread receiver([&] {
    std::ofstream out(folder_ / "log.nmea", std::ios::binary);
    const std::string text = rmc("120000", "010125") + gga("120001") + gga("120002");
    for (const char c : text) out << c << std::flush;
  });
  int count = 0;
  while (const auto m = source->next()) {
    EXPECT_EQ(m->arrival - m->stamp, from_seconds(0.25));
    ++count;
  }
  receiver.join();
  EXPECT_EQ(count, 3);
  EXPECT_LT(source->progress(), 0.0);
}

TEST_F(Nmea, AGrowingFileIsFollowed) {
  write(rmc("120000", "010125"));
  const auto source = make("follow_s: 5\n");
  std::thread receiver([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    std::ofstream(folder_ / "log.nmea", std::ios::app) << gga("120001") << gga("120002");
  });
  EXPECT_TRUE(source->next());
  EXPECT_TRUE(source->next());
  receiver.join();
}

TEST_F(Nmea, NoWrongByteAndNoEndDoesHarm) {
  const std::string text = gga("120000") + line("GNGST,120000,1.0,,,,0.3,0.4,0.9") + rmc("120000", "311224") +
                           line("GPVTG,45.0,T,,M,99.0,N,183.3,K,A") + line("GPZDA,120000,31,12,2024,00,00") +
                           line("GPGLL,4931.2,N,00830.0,E,120001,A,D") + line("HEHDT,20.0,T");
  const std::string keys = "heading: { sensor: compass }\nrequire_checksum: false\nmax_bad_records: 1000\n";
  for (std::size_t at = 0; at < text.size(); ++at) {
    EXPECT_LE(read(text.substr(0, at), keys).size(), 3U);
    for (const char other : {'\0', '9', ',', '$', '\xff'}) {
      std::string damaged = text;
      damaged[at] = other;
      const std::size_t star = damaged.find('*', at);
      if (star != std::string::npos) damaged.replace(star, 1, ",");  // no checksum, so that the damage is looked at
      for (const Measurement& m : read(damaged, keys)) {
        if (m.sensor != 0 || m.as<GnssFix>().type == GnssFix::Type::none) continue;
        EXPECT_LE(std::abs(m.as<GnssFix>().latitude_deg), 90.0);
      }
    }
  }
}

}  // namespace
}  // namespace waymark
