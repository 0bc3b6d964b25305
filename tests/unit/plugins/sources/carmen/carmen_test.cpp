// SPDX-License-Identifier: Apache-2.0
// How the source carmen reads messages, their times, odometry, and lines that cannot be used.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <zlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

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

constexpr double kExact = 1e-12;
constexpr double kDegree = std::numbers::pi / 180.0;

std::string times(double ipc) { return fmt::format(" {:.6f} host {:.6f}\n", ipc, ipc - 90.0); }

std::string odom(double ipc, const std::string& pose, double tv = 0.0) {
  return fmt::format("ODOM {} {:.3f} 0.0 0.0", pose, tv) + times(ipc);
}

/// A scan of `beams` beams, all of one range; the laser 0.5 m ahead of the robot.
std::string flaser(double ipc, double x, double y = 0.0, double theta = 0.0, int beams = 180, double range = 1.5,
                   const std::string& name = "FLASER") {
  std::string line = fmt::format("{} {}", name, beams);
  for (int i = 0; i < beams; ++i) line += fmt::format(" {:.2f}", range);
  return line + fmt::format(" {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f}", x + 0.5, y, theta, x, y, theta) + times(ipc);
}

class Carmen : public ::testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(folder_ / "robot.log", std::ios::binary) << text; }
  std::shared_ptr<Source> make(const std::string& more = kScansAndWheels) const {
    const Config config = Config::parse("file: robot.log\n" + more, (folder_ / "run.yaml").string());
    const Rig rig({{"wheels", "", std::nullopt},
                   {"front", "waymark/LaserScan@1", Pose::planar(0.5, 0.0, 0.0)},
                   {"rear", "waymark/LaserScan@1", std::nullopt},
                   {"gps", "", std::nullopt}});
    auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("carmen", config, rig);
    config.reject_unread();
    return source;
  }
  std::vector<Measurement> read(const std::string& text, const std::string& more = kScansAndWheels) {
    write(text);
    return read_written(more);
  }
  std::vector<Measurement> read_written(const std::string& more = kScansAndWheels) {
    const auto source = make(more);
    std::vector<Measurement> all;
    while (auto m = source->next()) all.push_back(std::move(*m));
    bad_.clear();
    for (const BadRecord& record : source->bad_records()) bad_.push_back(record.place + ": " + record.reason);
    notices_ = source->notices();
    return all;
  }
  template <class P>
  static std::vector<P> only(const std::vector<Measurement>& all) {
    std::vector<P> found;
    for (const Measurement& m : all) {
      if (m.payload->type() == P::kType) found.push_back(m.as<P>());
    }
    return found;
  }
  static double seconds(Time time) { return to_seconds(time.time_since_epoch()); }
  template <class E>
  std::string error_of(const std::string& more = kScansAndWheels) const {
    return test::source_error<E>([&] { return make(more); });
  }

  static inline const std::string kScansAndWheels =
      "lasers: [{ message: FLASER, sensor: front }]\nwheels: { sensor: wheels }\n";
  test::TemporaryFolder folder_;
  std::vector<std::string> bad_;
  std::vector<std::string> notices_;
};

TEST_F(Carmen, AScanComesWithTheStepThatLedToIt) {
  const auto all = read("# a comment\n" + flaser(100.25, 1.0, 2.0, 0.5 * std::numbers::pi) +
                        flaser(100.45, 1.0, 2.3, 0.5 * std::numbers::pi + 0.1) + flaser(100.7, 0.98, 2.3, 1.8));
  ASSERT_THAT(all, SizeIs(5));
  EXPECT_THAT(bad_, IsEmpty());
  EXPECT_THAT(notices_, IsEmpty());
  // The first scan, then each step before the scan at its end.
  const auto& scan = all[0].as<LaserScan>();
  EXPECT_EQ(format_time(all[0].stamp), "100.250000000");
  EXPECT_EQ(all[0].arrival, all[0].stamp);
  EXPECT_THAT(scan.ranges_m, SizeIs(180));
  EXPECT_FLOAT_EQ(scan.ranges_m[7], 1.5F);
  EXPECT_NEAR(scan.start_rad, -90 * kDegree, kExact);
  EXPECT_NEAR(scan.step_rad, 1 * kDegree, kExact);
  const auto& first = all[1].as<PoseIncrement>();
  EXPECT_EQ(format_time(all[1].stamp), "100.250000000");
  EXPECT_EQ(format_time(all[1].arrival), "100.450000000");
  EXPECT_NEAR(first.interval_s, 0.2, kExact);
  EXPECT_NEAR(first.x_m, 0.3, 1e-6);
  EXPECT_NEAR(first.y_m, 0.0, 1e-6);
  EXPECT_NEAR(first.yaw_rad, 0.1, 1e-6);
  EXPECT_EQ(format_time(all[2].stamp), "100.450000000");
  // The step from the second scan on, one nanosecond behind it.
  EXPECT_EQ(format_time(all[3].stamp), "100.450000001");
  EXPECT_NEAR(all[3].as<PoseIncrement>().interval_s, 0.25, kExact);
  EXPECT_NEAR(all[3].as<PoseIncrement>().y_m, 0.02 * std::cos(0.1), 1e-6) << "the sideways part is kept";
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].sequence, i);
}

TEST_F(Carmen, TheNumberOfBeamsTellsTheirStep) {
  const auto step = [&](int beams) {
    return only<LaserScan>(read(flaser(1, 0, 0, 0, beams))).at(0).step_rad / kDegree;
  };
  EXPECT_NEAR(step(180), 1.0, kExact);
  EXPECT_NEAR(step(181), 1.0, kExact);
  EXPECT_NEAR(step(360), 0.5, kExact);
  EXPECT_NEAR(step(361), 0.5, kExact);
  write(flaser(1, 0, 0, 0, 682));
  EXPECT_THAT(error_of<DataError>(), AllOf(HasSubstr("robot.log:1: 682 beams"), HasSubstr("step_deg")));
  const auto given =
      only<LaserScan>(read_written("lasers: [{ message: FLASER, sensor: front, start_deg: -120, step_deg: 0.352 }]"));
  EXPECT_NEAR(given.at(0).start_rad, -120 * kDegree, kExact);
  EXPECT_NEAR(given.at(0).step_rad, 0.352 * kDegree, kExact);
}

TEST_F(Carmen, NewMessagesTellTheirBeamsAndRemissions) {
  const std::string line =
      "ROBOTLASER1 0 -1.5 3.0 0.75 81.9 0.01 1 3 1.0 2.0 3.0 3 7 8 9 5.5 0 0 5.0 0.0 0.25 0.3 0.0 0.5 0.5 1e6" +
      times(7.0);
  const std::string rear = "RLASER 2 4.0 5.0 0 0 0 0 0 0" + times(7.1);
  const auto all = read(line + rear,
                        "lasers: [{ message: ROBOTLASER1, sensor: front }, "
                        "{ message: RLASER, sensor: rear, start_deg: 90, step_deg: 180 }]");
  ASSERT_THAT(all, SizeIs(2));
  const auto& scan = all[0].as<LaserScan>();
  EXPECT_THAT(scan.ranges_m, ElementsAre(1.0F, 2.0F, 3.0F));
  EXPECT_THAT(scan.intensities, ElementsAre(7.0F, 8.0F, 9.0F));
  EXPECT_EQ(scan.start_rad, -1.5);
  EXPECT_EQ(scan.step_rad, 0.75);
  EXPECT_EQ(all[1].sensor, 1u);
  EXPECT_THAT(all[1].as<LaserScan>().ranges_m, ElementsAre(4.0F, 5.0F));
}

TEST_F(Carmen, PosesMayBeThoseOfOdomOrOfBoth) {
  const std::string log = flaser(1.0, 0.0) + odom(1.1, "0.2 0 0") + flaser(1.2, 0.3) + odom(1.4, "0.7 0 0");
  const auto lengths = [&](const std::string& poses) {
    std::vector<double> all;
    for (const auto& step : only<PoseIncrement>(read(
             log, "lasers: [{ message: FLASER, sensor: front }]\nwheels: { sensor: wheels, poses: " + poses + " }")))
      all.push_back(std::round(1e6 * step.x_m) / 1e6);
    return all;
  };
  EXPECT_THAT(lengths("scans"), ElementsAre(0.3));
  EXPECT_THAT(lengths("odom"), ElementsAre(0.5));
  EXPECT_THAT(lengths("all"), ElementsAre(0.2, 0.1, 0.4));
}

TEST_F(Carmen, StampsThatStepBackArePutInOrder) {
  const auto all =
      read(flaser(10.0, 0.0) + odom(10.3, "0 0 0") + flaser(10.4, 0.4) + flaser(10.2, 0.2) + flaser(10.6, 0.6));
  std::vector<std::string> stamps;
  for (const Measurement& m : all) {
    if (m.payload->type() == LaserScan::kType) stamps.push_back(format_time(m.stamp).substr(0, 4));
  }
  EXPECT_THAT(stamps, ElementsAre("10.0", "10.2", "10.4", "10.6"));
  for (const PoseIncrement& step : only<PoseIncrement>(all)) EXPECT_NEAR(step.x_m, 0.2, 1e-9);
  ASSERT_THAT(notices_, SizeIs(1));
  EXPECT_THAT(notices_[0], HasSubstr("stamps step back, by up to 0.200 s: 1 FLASER; put in order"));
}

TEST_F(Carmen, OfEqualStampsTheLastPoseCountsAndNoMotionIsLost) {
  const auto steps =
      only<PoseIncrement>(read(flaser(1.0, 0.0) + flaser(1.2, 0.1) + flaser(1.2, 0.2) + flaser(1.4, 0.3)));
  ASSERT_THAT(steps, SizeIs(2));
  EXPECT_NEAR(steps[0].x_m, 0.2, 1e-9);
  EXPECT_NEAR(steps[1].x_m, 0.1, 1e-9);
}

// Two stretches: steps 1 and 2, and step 4. Step 3 goes back as it should; step 5 is forward in both.
TEST_F(Carmen, OdometryThatGoesForwardInReverseIsTurnedRound) {
  std::string log = flaser(1.0, 0.0, 0.0);
  const std::vector<std::pair<double, double>> to_and_speed{
      {0.1, -0.2}, {0.2, -0.2}, {0.15, -0.2}, {0.25, -0.3}, {0.4, 0.3}};
  for (std::size_t i = 0; i < to_and_speed.size(); ++i) {
    const double t = 1.2 + 0.2 * static_cast<double>(i);
    log += odom(t - 0.11, "0 0 0", to_and_speed[i].second) + flaser(t, to_and_speed[i].first, 0.01, 0.0);
  }
  const auto repaired = only<PoseIncrement>(read(log));
  ASSERT_THAT(repaired, SizeIs(5));
  const std::vector<double> right{-0.1, -0.1, -0.05, -0.1, 0.15};
  for (std::size_t i = 0; i < right.size(); ++i) EXPECT_NEAR(repaired[i].x_m, right[i], 1e-9) << i;
  EXPECT_NEAR(repaired[0].y_m, -0.01, 1e-9);
  ASSERT_THAT(notices_, SizeIs(1));
  EXPECT_THAT(notices_[0], HasSubstr("in 3 steps (2 stretches, 0.3 m in all)"));

  const auto logged = only<PoseIncrement>(
      read_written("lasers: [{ message: FLASER, sensor: front }]\nwheels: { sensor: wheels, reversals: as_logged }"));
  EXPECT_NEAR(logged[0].x_m, 0.1, 1e-9);
  EXPECT_THAT(notices_, IsEmpty());
}

TEST_F(Carmen, AJumpOfOdometryIsNoMotion) {
  const std::string log = flaser(1.0, 0.0) + flaser(1.2, 0.1) + flaser(1.4, 50.0) + flaser(1.6, 50.1);
  write(log);
  EXPECT_THAT(error_of<DataError>(), AllOf(HasSubstr("robot.log:3"), HasSubstr("49.900 m in 0.200 s")));
  const auto steps = only<PoseIncrement>(read_written(kScansAndWheels + "max_bad_records: 1"));
  ASSERT_THAT(steps, SizeIs(2));
  EXPECT_NEAR(steps[1].x_m, 0.1, 1e-9);
  EXPECT_THAT(bad_, SizeIs(1));
}

TEST_F(Carmen, AJumpTooManyEndsTheLogButNotWhatCameBefore) {
  write(flaser(100.0, 0, 0, 0) + flaser(100.2, 0.1, 0, 0) + flaser(100.4, 70, 0, 0) + flaser(100.6, 70.1, 0, 0));
  const auto source = make(kScansAndWheels);
  std::vector<Measurement> before;
  std::string why;
  try {
    while (auto m = source->next()) before.push_back(std::move(*m));
  } catch (const DataError& error) {
    why = error.what();
  }
  EXPECT_THAT(why, HasSubstr("odometry jumps by 69.900 m"));
  EXPECT_THAT(only<LaserScan>(before), SizeIs(2));
  EXPECT_THAT(only<PoseIncrement>(before), SizeIs(1));
}

TEST_F(Carmen, APictureIsNoLogAndSaysSoShortly) {
  std::string text = "\x89PNG\x01\x02\n";
  for (int i = 0; i < 100; ++i) text += fmt::format("word{} 1 2\n", i);
  EXPECT_THAT(read(text), IsEmpty());
  ASSERT_THAT(notices_, SizeIs(1));
  EXPECT_THAT(notices_[0], HasSubstr("1 lines that are not messages"));
  EXPECT_THAT(notices_[0], HasSubstr("and 93 other kinds"));
  EXPECT_LT(notices_[0].size(), 300u);
}

TEST_F(Carmen, FixesTellPositionAndQuality) {
  const auto tail = [](double t) { return " 100.0 0 48.0 0 0" + times(t); };
  const auto all = read("NMEAGGA 1 123456 4930.6 N 830.3 W 2 9 1.2" + tail(5.0) + "NMEAGGA 1 123457 0 N 0 E 0 0 99" +
                            tail(6.0) + "NMEAGGA 1 0 4975.0 N 800 E 1 9 1" + tail(7.0),
                        "gnss: { sensor: gps }\nmax_bad_records: 1");
  ASSERT_THAT(all, SizeIs(2));
  const auto& fix = all[0].as<GnssFix>();
  EXPECT_NEAR(fix.latitude_deg, 49.51, 1e-9);
  EXPECT_NEAR(fix.longitude_deg, -8.505, 1e-9);
  EXPECT_EQ(fix.type, GnssFix::Type::differential);
  EXPECT_EQ(fix.satellites, 9);
  EXPECT_EQ(fix.hdop, 1.2);
  EXPECT_TRUE(std::isnan(fix.height_m));
  EXPECT_EQ(all[1].as<GnssFix>().type, GnssFix::Type::none);
  EXPECT_THAT(bad_, ElementsAre(AllOf(HasSubstr("robot.log:3"), HasSubstr("\"4975.0\" \"N\""))));
}

TEST_F(Carmen, WhatIsNotReadIsCountedByName) {
  read("SYNC tag 1 host 0\nTRUEPOS 1 2 3 4 5 6 1 host 0\n" + flaser(1, 0) + "SYNC tag 2 host 0\n",
       "lasers: [{ message: FLASER, sensor: front }]");
  EXPECT_THAT(notices_, ElementsAre("robot.log: messages passed over: 2 SYNC, 1 TRUEPOS"));
}

TEST_F(Carmen, AnOffsetThatIsNotTheYamlsIsShown) {
  read("PARAM robot_frontlaser_offset 0.3 1071078718.4 host 1071078718.4\n" + flaser(1, 0));
  EXPECT_THAT(notices_, ElementsAre(AllOf(HasSubstr("robot.log:1: robot_frontlaser_offset is 0.3 m"),
                                          HasSubstr("sensors.front has x 0.500 m"))));
  read("PARAM robot_frontlaser_offset 0.5 nohost 0\n" + flaser(1, 0));
  EXPECT_THAT(notices_, IsEmpty());
}

TEST_F(Carmen, TimesMayBeTheLoggersOrThoseOfTheLines) {
  const std::string log = "PARAM a b nohost 0\n" + flaser(100, 0.0) + odom(100, "0.5 0 0") + "# x\n" + flaser(90, 1.0);
  write(log);
  const auto stamps = [&](const std::string& more) {
    std::vector<double> all;
    for (const Measurement& m : read_written("lasers: [{ message: FLASER, sensor: front }]\n" + more))
      all.push_back(seconds(m.stamp));
    return all;
  };
  EXPECT_THAT(stamps("times: logger"), ElementsAre(0.0, 10.0));
  EXPECT_THAT(stamps("times: lines\nline_interval_s: 0.5"), ElementsAre(0.5, 1.5)) << "PARAM and comments do not count";
}

TEST_F(Carmen, LinesOfOtherShapesAreBadRecords) {
  const std::string good = flaser(1.0, 0.0);
  const std::vector<std::pair<std::string, std::string>> lines{
      {"ODOM 1 2 3 0 0\n", "ODOM has 6 words, 10 are expected"},
      {"ODOM 1 two 3 0 0 0" + times(1), "y (word 3) is \"two\", a number is expected"},
      {"ODOM 1 nan 3 0 0 0" + times(1), "\"nan\""},
      {"ODOM 1 2 3 0 0 0 soon host 0\n", "ipc_timestamp (word 8) is \"soon\""},
      {"FLASER 180 1 2 3" + times(1), "FLASER has 8 words, 191 are expected"},
      {"FLASER -3 1 2 3" + times(1), "num_readings (word 2) is \"-3\""},
      {"FLASER 0 1 2 3 1 2 3" + times(1), "num_readings is 0"},
      {good.substr(0, good.size() / 2) + "\n", "words"},
      {"PARAM robot_length\n", "a value"}};
  for (const auto& [line, reason] : lines) {
    const auto all = read(good + line + flaser(1.2, 0.1), kScansAndWheels + "max_bad_records: 1");
    EXPECT_THAT(bad_, ElementsAre(AllOf(HasSubstr("robot.log:2: "), HasSubstr(reason)))) << line;
    EXPECT_THAT(only<LaserScan>(all), SizeIs(2)) << line;
    EXPECT_THAT(error_of<DataError>(), HasSubstr("robot.log:2: ")) << line;
  }
}

class CarmenGzip : public Carmen {
 protected:
  void compress(const std::string& text) const {
    const gzFile file = gzopen((folder_ / "robot.log").c_str(), "wb");
    gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
    gzclose(file);
  }
};

TEST_F(CarmenGzip, GivesTheSameAndSaysWhereItIsCutOff) {
  std::string log;
  for (int k = 0; k < 400; ++k) log += flaser(1.0 + 0.2 * k, 0.01 * k, 0.001 * (k % 7), 0.002 * (k % 31));
  compress(log);
  const auto packed = read_written();
  const auto plain = read(log);
  ASSERT_EQ(packed.size(), plain.size());
  ASSERT_EQ(packed.size(), 799u);
  for (std::size_t i = 0; i < packed.size(); ++i) EXPECT_EQ(packed[i].stamp, plain[i].stamp);

  compress(log);
  std::filesystem::resize_file(folder_ / "robot.log", std::filesystem::file_size(folder_ / "robot.log") / 2);
  const auto source = make();
  std::size_t delivered = 0;
  try {
    while (source->next()) ++delivered;
    ADD_FAILURE() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("robot.log:"), HasSubstr("ends early")));
  }
  EXPECT_GT(delivered, 100u) << "what lies before the damage is delivered";
  EXPECT_LT(delivered, 799u);
}

TEST_F(Carmen, RefusesWhatDoesNotFit) {
  write(flaser(1, 0));
  EXPECT_THAT(error_of<ConfigError>("times: ipc"), HasSubstr("none of lasers, wheels and gnss"));
  EXPECT_THAT(error_of<ConfigError>("wheels: { sensor: wheels }"), HasSubstr("needs an entry of lasers"));
  EXPECT_THAT(error_of<ConfigError>("wheels: { sensor: front, poses: odom }"),
              HasSubstr("takes waymark/LaserScan@1, but this gives waymark/PoseIncrement@1"));
  EXPECT_THAT(error_of<ConfigError>("lasers: [{ message: FLASER, sensor: back }]"), HasSubstr("no sensor \"back\""));
  EXPECT_THAT(error_of<ConfigError>("lasers: [{ message: LASER9, sensor: front }]"), HasSubstr("FLASER"));
  EXPECT_THAT(error_of<ConfigError>(kScansAndWheels + "colour: red"), HasSubstr("colour"));
  std::filesystem::remove(folder_ / "robot.log");
  EXPECT_THAT(error_of<ConfigError>(), HasSubstr("robot.log cannot be read: No such file"));
}

}  // namespace
}  // namespace waymark
