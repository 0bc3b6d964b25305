// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry, simulator, tum
// Which files a log consists of, what describes them, and what is refused.
#include <gmock/gmock.h>

#include <cmath>

#include "log_fixture.hpp"

namespace waymark {
namespace {

using test::LogSink;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// A payload that nobody knows.
struct Smell : PayloadOf<Smell> {
  static constexpr std::string_view kType = "test/Smell@1";
};

TEST_F(LogSink, WritesOneFilePerSensorWithTimesInNanoseconds) {
  start();
  arrive(0, wheels(0.1, -1e-20), 1'248'272'272'841'000'001);
  arrive(0, wheels(1.0 / 3.0, 2.0), 1'248'272'272'841'000'002, 1'248'272'272'900'000'000);
  sink_->finish(nullptr, {});
  EXPECT_THAT(out_.lines("log/wheels.csv"),
              ElementsAre("t_ns,arrival_ns,left_mps,right_mps", "1248272272841000001,1248272272841000001,0.1,-1e-20",
                          "1248272272841000002,1248272272900000000,0.3333333333333333,2"));
}

TEST_F(LogSink, FilesAppearWhenTheyAreComplete) {
  start();
  arrive(0, WheelSpeeds{}, 0);
  EXPECT_FALSE(out_.has("log/wheels.csv"));
  EXPECT_TRUE(out_.has("log/wheels.csv.partial"));
  sink_->finish(nullptr, {});
  EXPECT_TRUE(out_.has("log/wheels.csv"));
  EXPECT_FALSE(out_.has("log/wheels.csv.partial"));
}

TEST_F(LogSink, EqualArrivalsKeepTheirOrder) {
  start();
  // The camera speaks first of all, but with equal arrivals it comes last.
  arrive(2, CompassHeading{}, 0);
  for (std::int64_t t = 10; t < 40; t += 10) {
    arrive(3, GnssFix{}, t - 5, t);
    arrive(0, WheelSpeeds{}, t);
    arrive(2, CompassHeading{}, t - 1, t);
  }
  same_order<WheelSpeeds>();
}

TEST_F(LogSink, WritesTheReference) {
  auto reference = std::make_shared<Reference>();
  reference->trajectory = {{Time{Duration{1}}, Pose::planar(1.0, 2.0, 0.5), true},
                           {Time{Duration{2}}, Pose::planar(3.0, 4.0, 0.0), false}};
  reference->landmarks = {{"#1, an elm", {1.5, 2.5}, 0.25}, {"2", {3.0, 4.0}, std::nan("")}};
  start("{}", reference);
  arrive(0, WheelSpeeds{}, 0);
  read_back();
  const auto got = source_->reference();
  ASSERT_NE(got, nullptr);
  ASSERT_THAT(got->trajectory, SizeIs(2));
  EXPECT_EQ(got->trajectory[0].stamp, reference->trajectory[0].stamp);
  EXPECT_TRUE(got->trajectory[0].T_map_base.q.isApprox(reference->trajectory[0].T_map_base.q, 1e-15));
  EXPECT_EQ(got->trajectory[1].T_map_base.p, reference->trajectory[1].T_map_base.p);
  EXPECT_FALSE(got->trajectory[1].has_yaw);
  ASSERT_THAT(got->landmarks, SizeIs(2));
  EXPECT_EQ(got->landmarks[0].name, "#1_ an elm");
  EXPECT_EQ(got->landmarks[0].radius_m, 0.25);
  EXPECT_TRUE(std::isnan(got->landmarks[1].radius_m));
}

TEST_F(LogSink, WithoutReferenceThereIsNone) {
  start("{}", std::make_shared<Reference>());
  arrive(0, WheelSpeeds{}, 0);
  read_back();
  EXPECT_EQ(source_->reference(), nullptr);
}

const std::string kRobot =
    "plugin_path: [../mine]\n"
    "source: { plugin: simulator, duration_s: 5 }\n"
    "sensors:\n"
    "  - { name: wheels, plugin: odometry }\n"
    "  - { name: front lidar, payload: LaserScan }\n"
    "  - { name: camera, payload: Image }\n"
    "  - { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0.5] }\n"
    "maps:\n"
    "  - { name: pillars, plugin: feature_map, inputs: [gps, camera] }\n"
    "  - { name: trees, plugin: feature_map, inputs: [front lidar] }\n"
    "sinks: [{ plugin: log }, { plugin: tum, path: \"$${x}\" }, { plugin: log, folder: other }]\n";

TEST_F(LogSink, TheReplayIsTheRobotWithTheLogAsSource) {
  start("{}", nullptr, kRobot);
  arrive(0, WheelSpeeds{}, 0);
  arrive(3, GnssFix{}, 0);
  sink_->finish(nullptr, {});
  const Config replay = Config::load(out_.path() / "log/replay.yaml");
  EXPECT_EQ(replay.child("source").text("plugin"), "csv");
  EXPECT_THAT(replay.child("source").items("files"), SizeIs(2));
  EXPECT_FALSE(replay.child("source").has("duration_s"));
  const auto sensors = replay.items("sensors");
  ASSERT_THAT(sensors, SizeIs(4));
  EXPECT_FALSE(sensors[0].has("enabled"));
  EXPECT_FALSE(sensors[1].boolean("enabled")) << "the log has nothing for it";
  EXPECT_FALSE(sensors[2].boolean("enabled"));
  EXPECT_FALSE(sensors[3].has("enabled"));
  EXPECT_EQ(sensors[3].numbers("base_p_antenna_m"), (std::vector<double>{0.0, 0.0, 0.5}));
  const auto maps = replay.items("maps");
  EXPECT_FALSE(maps[0].has("enabled"));
  EXPECT_FALSE(maps[1].boolean("enabled")) << "nothing triggers it";
  const auto sinks = replay.items("sinks");
  EXPECT_FALSE(sinks[0].boolean("enabled"));
  EXPECT_FALSE(sinks[1].has("enabled"));
  EXPECT_EQ(sinks[1].text("path"), "${x}");
  EXPECT_FALSE(sinks[2].boolean("enabled"));
  EXPECT_THAT(replay.texts("plugin_path"), ElementsAre((out_.path().parent_path() / "mine").string()));
}

TEST_F(LogSink, AReadingThatIsNoNumberComesBackForTheHostToRefuse) {
  start("{}");
  WheelSpeeds wheels;
  arrive(0, wheels, 0);
  wheels.left_mps = std::numeric_limits<double>::quiet_NaN();
  arrive(0, wheels, 1);
  sink_->finish(nullptr, {});
  const Config source = Config::load(out_.path() / "log/source.yaml").child("source");
  EXPECT_TRUE(source.items("files").at(0).boolean("keep_invalid"));
  EXPECT_GT(source.number("max_ahead_s"), 0.0);
}

TEST_F(LogSink, WithoutAConfigurationThereIsNoReplay) {
  start();
  arrive(0, WheelSpeeds{}, 0);
  sink_->finish(nullptr, {});
  EXPECT_TRUE(out_.has("log/source.yaml"));
  EXPECT_FALSE(out_.has("log/replay.yaml"));
}

TEST_F(LogSink, WithoutMeasurementsThereIsNothingToRead) {
  start("{}", nullptr, kRobot);
  sink_->finish(nullptr, {});
  EXPECT_TRUE(std::filesystem::is_empty(out_.path() / "log"));
}

TEST_F(LogSink, AnOlderLogIsNotDescribedAnyMore) {
  start("{}", nullptr, kRobot);
  arrive(0, WheelSpeeds{}, 0);
  sink_->finish(nullptr, {});
  start("{}", nullptr, kRobot);
  EXPECT_FALSE(out_.has("log/source.yaml"));
  EXPECT_FALSE(out_.has("log/replay.yaml"));
}

TEST_F(LogSink, AnUnknownPayloadIsAnErrorThatNamesTheWayOut) {
  start();
  arrive(0, WheelSpeeds{}, 0);
  EXPECT_THAT(error_of([&] { arrive(2, Smell{}, 1); }),
              AllOf(HasSubstr("sensor camera"), HasSubstr("test/Smell@1"), HasSubstr("leave_out: [camera]")));
  EXPECT_TRUE(out_.has("log/wheels.csv")) << "what was written is kept";
  EXPECT_TRUE(out_.has("log/source.yaml"));
}

TEST_F(LogSink, LeavesSensorsOut) {
  start("{ leave_out: [camera] }");
  arrive(0, WheelSpeeds{}, 0);
  arrive(2, Smell{}, 1);
  EXPECT_THAT(read_back(), SizeIs(1));
}

TEST_F(LogSink, ArrivalsThatGoBackAreAnError) {
  start();
  arrive(0, WheelSpeeds{}, 5, 10);
  EXPECT_THAT(error_of([&] { arrive(0, WheelSpeeds{}, 6, 9); }),
              AllOf(HasSubstr("sensor wheels"), HasSubstr("0.000000010"), HasSubstr("0.000000009")));
}

TEST_F(LogSink, RefusesWhatItCannotUse) {
  for (const char* folder : {"''", ".", "..", "/tmp/x", "a/../.."}) {
    EXPECT_THAT(error_of([&] { make(std::string("{ folder: ") + folder + " }"); }), HasSubstr("folder")) << folder;
  }
  EXPECT_THAT(error_of([&] { make("{ leave_out: [nose] }"); }), HasSubstr("no sensor \"nose\""));
  EXPECT_THAT(error_of([&] { make("{ png_compression: 10 }"); }), HasSubstr("png_compression"));
}

TEST_F(LogSink, AFolderThatCannotBeMadeIsAnError) {
  std::ofstream(out_.path() / "log") << "in the way";
  EXPECT_THAT(error_of([&] { start(); }), HasSubstr((out_.path() / "log").string()));
}

TEST_F(LogSink, SnapshotsAddNothing) {
  start();
  arrive(0, WheelSpeeds{}, 0);
  test::FakeSnapshot snapshot;
  sink_->write(snapshot);
  EXPECT_THAT(read_back(), SizeIs(1));
}

}  // namespace
}  // namespace waymark
