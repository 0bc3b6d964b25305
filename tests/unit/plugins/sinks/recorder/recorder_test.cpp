// SPDX-License-Identifier: Apache-2.0
// needs plugins: mcap
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <bit>
#include <csignal>
#include <fstream>
#include <thread>

#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/mcap/file.hpp"
#include "recording.hpp"
#include "unit/plugins/sinks/fake_snapshot.hpp"
#include "waymark/interface/command.hpp"

namespace waymark::recorder_test {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const Rig kRig{{{"wheels", "", std::nullopt}, {"lidar", "", std::nullopt}, {"silent", "", std::nullopt}}};

Time at(std::int64_t nanoseconds) { return Time{Duration{nanoseconds}}; }

template <class T>
Measurement measure(std::uint32_t sensor, std::uint64_t sequence, std::int64_t stamp, std::int64_t arrival, T payload) {
  Measurement m;
  m.sensor = sensor;
  m.sequence = sequence;
  m.stamp = at(stamp);
  m.arrival = at(arrival);
  m.payload = std::make_shared<T>(std::move(payload));
  return m;
}

WheelSpeeds wheels(double left, double right = 0.5) {
  WheelSpeeds speeds;
  speeds.left_mps = left;
  speeds.right_mps = right;
  return speeds;
}

LaserScan scan(std::vector<float> ranges) {
  LaserScan scan;
  scan.start_rad = 0.1 + 0.2;
  scan.step_rad = 1e-3;
  scan.ranges_m = std::move(ranges);
  return scan;
}

std::shared_ptr<Source> replay(const TemporaryFolder& out, const std::string& more = "") {
  const Config config = Config::parse("file: flight.mcap\n" + more, (out / "run.yaml").string());
  return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("mcap", config, kRig);
}

std::vector<Measurement> read_all(Source& source) {
  std::vector<Measurement> all;
  while (auto m = source.next()) all.push_back(std::move(*m));
  return all;
}

RunInfo info(const TemporaryFolder& out) { return {out.path(), &kRig, nullptr, "source: { plugin: x }\n"}; }

TEST(Recorder, EveryMeasurementIsRestoredExactly) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  std::vector<Measurement> sent;
  const std::uint64_t late = (std::uint64_t{7} << 32U) - 2;  // the lower 32 bits overflow
  for (std::int64_t k = 0; k < 500; ++k) {
    const std::int64_t arrival = 1'700'000'000'000'000'000 + k * 10'000'000;
    sent.push_back(
        measure(0, late + static_cast<std::uint64_t>(2 * k), arrival - k * 1000, arrival, wheels(0.1 * k, -0.0)));
    sent.push_back(measure(1, late + static_cast<std::uint64_t>(2 * k + 1), arrival - 20'000'000, arrival,
                           scan({0.1f, std::numeric_limits<float>::infinity(), 0.0f + static_cast<float>(k)})));
  }
  for (const Measurement& m : sent) sink->arrived(m);
  sink->finish(nullptr, {});

  const auto source = replay(out);
  const auto got = read_all(*source);
  ASSERT_EQ(got.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    EXPECT_EQ(got[i].stamp, sent[i].stamp);
    EXPECT_EQ(got[i].arrival, sent[i].arrival);
    EXPECT_EQ(got[i].sequence, sent[i].sequence);
    EXPECT_EQ(source->channels()[got[i].sensor].sensor, kRig.mountings()[sent[i].sensor].name);
    ASSERT_EQ(got[i].payload->type(), sent[i].payload->type());
    EXPECT_EQ(ros::payload_to_cdr(*got[i].payload), ros::payload_to_cdr(*sent[i].payload));
  }
  EXPECT_THAT(source->bad_records(), IsEmpty());
  EXPECT_EQ(source->channels().back().sensor, "silent") << "a sensor that delivered nothing is not a mistake";
}

TEST(Recorder, CommandsComeBetweenTheMeasurementsAndDroppedOnesDoNot) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  sink->arrived(measure(0, 1, 10, 10, wheels(1.0)));
  sink->commanded(at(10), "disable \"lidar\"\n\xc3\xa4");
  sink->arrived(measure(0, 2, 20, 20, wheels(2.0)));
  sink->dropped(measure(1, 3, 15, 15, scan({1.0f})));
  sink->finish(nullptr, {});
  const auto source = replay(out);
  const auto got = read_all(*source);
  ASSERT_THAT(got, SizeIs(3));
  EXPECT_EQ(source->channels()[got[1].sensor].sensor, "");
  EXPECT_EQ(got[1].as<Command>().text, "disable \"lidar\"\n\xc3\xa4");
  EXPECT_EQ(got[1].arrival, at(10));
  EXPECT_EQ(got[2].as<WheelSpeeds>().left_mps, 2.0);
  EXPECT_THAT(source->notices(), ElementsAre(HasSubstr("1 measurements of \"lidar\" that the robot dropped")));
}

TEST(Recorder, TheRecordHasTheConfigurationAndTheVersions) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  sink->arrived(measure(0, 1, 10, 10, wheels(1.0)));
  sink->finish(nullptr, {});
  mcap::McapFile file(out / "flight.mcap");
  const auto config = file.attachment("config.yaml");
  ASSERT_TRUE(config);
  EXPECT_EQ(std::string(config->begin(), config->end()), "source: { plugin: x }\n");
  ASSERT_THAT(file.metadata(), SizeIs(1));
  EXPECT_EQ(file.metadata()[0].name, "waymark");
  EXPECT_EQ(file.header().profile, "waymark");
  EXPECT_EQ(file.channels().at(1).topic, "/waymark/wheels");
  EXPECT_EQ(file.schemas().at(1).name, "waymark_msgs/msg/WheelSpeeds");
}

TEST(Recorder, TheSameMeasurementsGiveTheSameBytes) {
  std::vector<std::string> files;
  for (const int pause_ms : {0, 1}) {
    const TemporaryFolder out;
    const auto sink = make_sink("recorder");
    sink->start(info(out));
    for (std::int64_t k = 0; k < 300; ++k) {
      sink->arrived(measure(0, static_cast<std::uint64_t>(k), k * 10'000'000, k * 10'000'000, wheels(k)));
      if (k % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
    }
    sink->finish(nullptr, {});
    std::ifstream in(out / "flight.mcap", std::ios::binary);
    files.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  EXPECT_FALSE(files[0].empty());
  EXPECT_EQ(files[0], files[1]);
}

TEST(Recorder, ACrashLosesNoMoreThanTheLastSecond) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  for (std::int64_t k = 0; k < 1000; ++k)
    sink->arrived(measure(0, static_cast<std::uint64_t>(k), k * 10'000'000, k * 10'000'000, wheels(k)));
  // The file as it is now, without an end.
  std::size_t count = 0;
  for (int i = 0; i < 500 && count < 900; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const TemporaryFolder copy;
    std::filesystem::copy_file(out / "flight.mcap", copy / "flight.mcap");
    try {
      count = read_all(*replay(copy)).size();
    } catch (const ConfigError&) {
      continue;  // nothing was written yet
    }
  }
  EXPECT_GE(count, 900U) << "of 10 s";
  EXPECT_LT(count, 1000U);
  sink->finish(nullptr, {});
  EXPECT_THAT(read_all(*replay(out)), SizeIs(1000));
}

TEST(Recorder, OfALiveRobotEverythingIsInTheFileAfterASecondOfSilence) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  sink->front(FakeSnapshot().belief());
  sink->arrived(measure(0, 1, 10, 10, wheels(1.0)));
  std::size_t count = 0;
  for (int i = 0; i < 100 && count == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const TemporaryFolder copy;
    std::filesystem::copy_file(out / "flight.mcap", copy / "flight.mcap");
    try {
      count = read_all(*replay(copy)).size();
    } catch (const ConfigError&) {
      continue;
    }
  }
  EXPECT_EQ(count, 1U);
  sink->finish(nullptr, {});
}

TEST(Recorder, ARecordThatWasCutOffIsReplayedUpToTheCut) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  for (std::int64_t k = 0; k < 1000; ++k)
    sink->arrived(measure(0, static_cast<std::uint64_t>(k), k * 10'000'000, k * 10'000'000, wheels(k)));
  sink->finish(nullptr, {});
  std::filesystem::resize_file(out / "flight.mcap", std::filesystem::file_size(out / "flight.mcap") / 2);
  const auto source = replay(out);
  const auto got = read_all(*source);
  EXPECT_GT(got.size(), 300U);
  ASSERT_THAT(source->bad_records(), SizeIs(1));
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("the file ends early"));
}

TEST(Recorder, AnOlderRecordIsKept) {
  const TemporaryFolder out;
  for (int run = 0; run < 3; ++run) {
    const auto sink = make_sink("recorder");
    sink->start(info(out));
    for (int k = 0; k <= run; ++k) sink->arrived(measure(0, static_cast<std::uint64_t>(k), k, k, wheels(k)));
    sink->finish(nullptr, {});
  }
  EXPECT_THAT(read_all(*replay(out)), SizeIs(3));
  EXPECT_TRUE(std::filesystem::exists(out / "flight.1.mcap"));
  EXPECT_TRUE(std::filesystem::exists(out / "flight.2.mcap"));
  EXPECT_FALSE(std::filesystem::exists(out / "flight.3.mcap"));
}

struct Opaque : PayloadOf<Opaque> {
  static constexpr std::string_view kType = "test/Opaque@1";
};

TEST(Recorder, APayloadWithoutFieldsIsLeftOutWithOneEvent) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  for (int k = 0; k < 3; ++k) sink->arrived(measure(1, static_cast<std::uint64_t>(k), k, k, Opaque()));
  sink->arrived(measure(0, 9, 10, 10, wheels(1.0)));
  std::vector<std::string> events;
  for (int i = 0; i < 500 && events.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    events = sink->take_events();
  }
  EXPECT_THAT(events, ElementsAre(HasSubstr("test/Opaque@1 is not recorded")));
  sink->finish(nullptr, {});
  EXPECT_THAT(read_all(*replay(out)), SizeIs(1));
}

TEST(Recorder, AFullDiskEndsTheRecordWithAnEventAndNothingElse) {
  const TemporaryFolder out;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const auto sink = make_sink("recorder", "compression: none");
  sink->start(info(out));
  rlimit small = before;
  small.rlim_cur = 100'000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  std::vector<std::string> events;
  for (int k = 0; k < 20000 && events.empty(); ++k) {
    const std::int64_t t = k * std::int64_t{100'000'000};
    EXPECT_NO_THROW(
        sink->arrived(measure(1, static_cast<std::uint64_t>(k), t, t, scan(std::vector<float>(100, 1.0f)))));
    if (k % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    events = sink->take_events();
  }
  EXPECT_THAT(events, ElementsAre(HasSubstr("the recording ended early: ")));
  EXPECT_NO_THROW(sink->arrived(measure(1, 99999, 1, 1, scan({1.0f}))));
  EXPECT_NO_THROW(sink->finish(nullptr, {}));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  const auto source = replay(out);
  EXPECT_GT(read_all(*source).size(), 50U);
  EXPECT_THAT(source->bad_records(), IsEmpty()) << "the file ends behind a whole chunk";
}

TEST(Recording, AQueueThatIsFullEndsTheRecordWithAnEvent) {
  const TemporaryFolder out;
  mcap::WriterOptions options;
  options.compression = mcap::WriterOptions::Compression::none;
  recorder::Recording recording(out / "flight.mcap", {options, {"wheels", "lidar", "silent"}, std::chrono::seconds(1)},
                                1 << 20);
  const Measurement large = measure(1, 1, 1, 1, scan(std::vector<float>(400'000, 1.0f)));  // more than the queue
  recording.add(recorder::Delivered{measure(0, 1, 10, 10, wheels(1.0)), false});
  recording.add(recorder::Delivered{large, false});
  recording.add(recorder::Delivered{measure(0, 2, 20, 20, wheels(1.0)), false});
  recording.finish();
  EXPECT_THAT(recording.take_events(), ElementsAre(HasSubstr("ended early: the disk is too slow")));
  EXPECT_THAT(read_all(*replay(out)), SizeIs(1)) << "what came before is kept";
  mcap::McapFile file(out / "flight.mcap");
  EXPECT_EQ(file.broken_because(), "") << "and the file is closed";
  EXPECT_EQ(file.metadata().back().name, "waymark.end");
}

TEST(Recorder, WithoutAnybodyToAskForEventsTheRunHearsOfThemAtItsEnd) {
  const TemporaryFolder out;
  const auto sink = make_sink("recorder");
  sink->start(info(out));
  sink->arrived(measure(1, 1, 1, 1, Opaque()));
  EXPECT_THROW(sink->finish(nullptr, {}), Error);
}

}  // namespace
}  // namespace waymark::recorder_test
