// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps
// A session with a source and sinks of the test's own: what becomes of the log, of the results, and of what fails.
#include "waymark/host/session.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "checkpoint_file.hpp"
#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/command.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kTwists = 40;  // ten a second

Measurement twist(int k) {
  auto payload = std::make_shared<BodyTwist>();
  payload->v_x_mps = 1.0 + 0.1 * (k % 7);
  payload->w_z_radps = 0.2;
  Measurement measurement;
  measurement.stamp = measurement.arrival = Time{} + from_seconds(0.1 * k);
  measurement.sequence = static_cast<std::uint64_t>(k);
  measurement.payload = payload;
  return measurement;
}

/// Twists for the wheels; throws after `good` of them if that is less than all.
class Twists : public Source {
 public:
  explicit Twists(int good = kTwists) : good_(good) {}
  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override {
    if (next_ == kTwists) return std::nullopt;
    if (next_ == good_) throw std::runtime_error("out of paper");
    return twist(next_++);
  }
  double progress() const override { return static_cast<double>(next_) / kTwists; }
  std::vector<std::string> notices() const override { return {"a log of twists"}; }

 private:
  std::vector<Channel> channels_{{"wheels", std::string(BodyTwist::kType)}};
  int good_;
  int next_ = 0;
};

/// Counts what it is given; throws at snapshot number `bad`.
class Counter : public Sink {
 public:
  explicit Counter(int bad = -1) : bad_(bad) {}
  void start(const RunInfo& info) override { config = info.config; }
  void arrived(const Measurement&) override { ++arrivals; }
  void write(const Snapshot&) override {
    if (++snapshots == bad_) throw std::runtime_error("no ink");
  }
  void finish(const Snapshot* last, const RunReport& given) override {
    ++finished;
    has_last = last != nullptr;
    report = given;
  }

  std::string config;
  int arrivals = 0;
  int snapshots = 0;
  int finished = 0;
  bool has_last = false;
  RunReport report;

 private:
  int bad_;
};

constexpr const char* kYaml = R"({ initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
  sensors: [{ name: wheels, plugin: odometry, model: twist }] })";

Robot live(const std::string& yaml = kYaml) {
  return Robot::live(Config::parse(yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
}

Robot robot(int good = kTwists) {
  Robot robot = live();
  robot.source = std::make_shared<Twists>(good);
  robot.sensor_of_channel = {0};
  return robot;
}

double x_at_end(const Session& session) {
  return session.fusion().front(Time{} + from_seconds(0.1 * kTwists)).mean.T_map_base.p.x();
}

TEST(Session, PlaysTheLogAndGivesItsResults) {
  Robot robot = host::robot();
  const auto sink = std::make_shared<Counter>();
  robot.sinks = {{"counter", sink}};
  std::vector<double> shares;
  Session session(std::move(robot), {.observer = [&](const Snapshot&, double share) { shares.push_back(share); }});
  session.play();
  const SessionResult result = session.finish();
  EXPECT_TRUE(result.started);
  EXPECT_THAT(result.failures, IsEmpty());
  EXPECT_THAT(result.report.notices, ElementsAre("a log of twists"));
  EXPECT_FALSE(result.report.interrupted);
  EXPECT_EQ(result.report.sensors.at(0).measurements, static_cast<std::uint64_t>(kTwists));
  EXPECT_THAT(sink->config, HasSubstr("model: twist"));
  EXPECT_EQ(sink->arrivals, kTwists);
  EXPECT_EQ(sink->snapshots, kTwists);
  EXPECT_EQ(sink->finished, 1);
  EXPECT_TRUE(sink->has_last);
  EXPECT_THAT(sink->report.notices, ElementsAre("a log of twists"));
  ASSERT_EQ(shares.size(), static_cast<std::size_t>(kTwists));
  EXPECT_EQ(shares.back(), 1.0);
}

TEST(Session, KeepsWhatCameBeforeTheLogFailed) {
  Robot robot = host::robot(5);
  const auto sink = std::make_shared<Counter>();
  robot.sinks = {{"counter", sink}};
  Session session(std::move(robot), {});
  session.play();
  const SessionResult result = session.finish();
  EXPECT_EQ(result.log_error, "the source failed: out of paper");
  EXPECT_THAT(result.failures, ElementsAre(result.log_error));
  EXPECT_EQ(sink->snapshots, 5);
  EXPECT_TRUE(sink->has_last);
}

/// A source whose truth has a bad row.
class NoTruth : public Twists {
 public:
  std::shared_ptr<const Reference> reference() const override { throw DataError("truth.csv:2: is no truth"); }
};

TEST(Session, RunsWithoutAReferenceThatCannotBeRead) {
  Robot robot = host::robot();
  robot.source = std::make_shared<NoTruth>();
  const auto sink = std::make_shared<Counter>();
  robot.sinks = {{"counter", sink}};
  Session session(std::move(robot), {});
  session.play();
  const SessionResult result = session.finish();
  EXPECT_EQ(result.log_error, "");
  EXPECT_THAT(result.failures, ElementsAre("no reference: truth.csv:2: is no truth"));
  EXPECT_EQ(sink->snapshots, kTwists);
}

/// A source that runs out of memory.
class NoMemory : public Twists {
 public:
  std::optional<Measurement> next() override {
    if (++asked_ > 5) throw std::bad_alloc();
    return Twists::next();
  }

 private:
  int asked_ = 0;
};

TEST(Session, KeepsWhatCameBeforeMemoryRanOut) {
  Robot robot = host::robot();
  robot.source = std::make_shared<NoMemory>();
  const auto sink = std::make_shared<Counter>();
  robot.sinks = {{"counter", sink}};
  Session session(std::move(robot), {.observer = [n = 0](const Snapshot&, double) mutable {
                    if (++n == 4) throw std::bad_alloc();
                  }});
  session.play();
  const SessionResult result = session.finish();
  EXPECT_THAT(result.log_error, HasSubstr("the run ended early: std::bad_alloc"));
  EXPECT_EQ(sink->finished, 1);
  EXPECT_TRUE(sink->has_last);
}

TEST(Session, KeepsItsResultsWhereTheCheckpointCannotBeWritten) {
  Robot robot = host::robot();
  const auto sink = std::make_shared<Counter>();
  robot.sinks = {{"counter", sink}};
  Session session(std::move(robot), {});
  session.play();
  const SessionResult result = session.suspend("/no/such/folder/half.ckpt");
  EXPECT_THAT(result.failures, ElementsAre(HasSubstr("the checkpoint is not written: /no/such/folder/half.ckpt")));
  EXPECT_EQ(sink->finished, 1);
}

TEST(Session, TwoInOneFolderAreRefused) {
  const test::TemporaryFolder folder;
  Session first(host::robot(), {.out = folder.path()});
  EXPECT_THROW(Session(host::robot(), {.out = folder.path()}), Error);
  const Session shared(host::robot(), {.out = folder.path(), .owns_folder = false});
}

TEST(Session, LeavesOutASinkThatFails) {
  Robot robot = host::robot();
  const auto bad = std::make_shared<Counter>(3);
  const auto good = std::make_shared<Counter>();
  robot.sinks = {{"printer", bad}, {"counter", good}};
  Session session(std::move(robot), {});
  session.play();
  const SessionResult result = session.finish();
  EXPECT_THAT(result.failures, ElementsAre("sink printer: taken out of service: no ink"));
  EXPECT_EQ(bad->snapshots, 3);
  EXPECT_EQ(bad->finished, 0);
  EXPECT_EQ(good->snapshots, kTwists);
  EXPECT_EQ(good->finished, 1);
}

TEST(Session, StopsBeforeTheNextMeasurement) {
  Robot robot = host::robot();
  const auto sink = std::make_shared<Counter>();
  robot.sinks = {{"counter", sink}};
  std::atomic<bool> stop{false};
  int arrived_before = 0;
  Session session(std::move(robot), {.stop = &stop, .observer = [&](const Snapshot&, double) {
                                       if (sink->snapshots != 7) return;
                                       stop = true;
                                       arrived_before = sink->arrivals;
                                     }});
  session.play();
  const SessionResult result = session.finish();
  EXPECT_GE(arrived_before, 7);
  EXPECT_LT(arrived_before, kTwists);
  EXPECT_EQ(sink->arrivals, arrived_before);
  EXPECT_EQ(sink->snapshots, arrived_before) << "what waited is committed";
  EXPECT_TRUE(result.report.interrupted);
  EXPECT_THAT(result.failures, IsEmpty());
}

TEST(Session, GoesOnFromACheckpointAsIfItHadNotEnded) {
  const test::TemporaryFolder folder;
  Session whole(robot(), {});
  whole.play();
  whole.finish();

  Session first(robot(), {.until_s = 1.55});
  first.play();
  const SessionResult half = first.suspend(folder / "half.ckpt");
  EXPECT_EQ(half.report.sensors.at(0).measurements, 16u);
  Session second(robot(), {});
  second.resume(folder / "half.ckpt");
  second.play();
  const SessionResult result = second.finish();
  EXPECT_EQ(result.report.sensors.at(0).measurements, static_cast<std::uint64_t>(kTwists));
  EXPECT_EQ(x_at_end(second), x_at_end(whole));
  EXPECT_NE(x_at_end(first), x_at_end(whole));
}

/// Twists, and after the twentieth a command.
class Commanded final : public Twists {
 public:
  explicit Commanded(std::string text) : text_(std::move(text)) {
    channels_ = Twists::channels();
    channels_.push_back({"", std::string(Command::kType)});
  }
  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override {
    if (read_++ != 20) return Twists::next();
    auto command = std::make_shared<Command>();
    command->text = text_;
    Measurement measurement = twist(19);
    measurement.sensor = 1;
    measurement.payload = command;
    return measurement;
  }

 private:
  std::string text_;
  std::vector<Channel> channels_;
  int read_ = 0;
};

Robot robot_with(const std::string& command) {
  Robot robot = live();
  robot.source = std::make_shared<Commanded>(command);
  robot.sensor_of_channel = {0, Robot::kCommands};
  return robot;
}

/// σ of the speed at the end, after a replay with that command.
double speed_sigma_after(const std::string& command) {
  Session session(robot_with(command), {});
  session.play();
  session.finish();
  const Belief belief = session.fusion().front(Time{} + from_seconds(0.1 * kTwists));
  return std::sqrt(belief.P(3, 3));
}

TEST(Session, AReplayRepeatsTheTuningOfASensor) {
  const double before = speed_sigma_after("");
  EXPECT_GT(speed_sigma_after("set sensors.wheels.speed_noise_m_per_sqrt_s=[0.5, 0.01]"), 1.5 * before);
  for (const char* refused :
       {"set sensors.wheels.speed_noise_m_per_sqrt_s=-1", "set sensors.wheels.nosie=1", "set filter.seed=2", "set",
        "set sensors.wheels.name=tracks", "set sensors.wheels.enabled=false", "set sensors.wheels.plugin=dgps",
        "set sensors.whels.model=twist", "set sensors.wheels.speed_scale_sigma=0.1"}) {
    EXPECT_EQ(speed_sigma_after(refused), before) << refused;
  }
}

TEST(Session, ACheckpointKeepsTheTuning) {
  const test::TemporaryFolder folder;
  const std::string command = "set sensors.wheels.speed_noise_m_per_sqrt_s=[0.5, 0.01]";
  Session whole(robot_with(command), {});
  whole.play();
  whole.finish();

  Session first(robot_with(command), {.until_s = 2.55});
  first.play();
  first.suspend(folder / "half.ckpt");
  Session second(robot_with(command), {});
  second.resume(folder / "half.ckpt");
  second.play();
  second.finish();
  const Time end = Time{} + from_seconds(0.1 * kTwists);
  EXPECT_EQ(second.fusion().front(end).P, whole.fusion().front(end).P);
  EXPECT_EQ(x_at_end(second), x_at_end(whole));
}

TEST(Session, BeginsAnewIfThereIsNoCheckpointToGoOnFrom) {
  const test::TemporaryFolder folder;
  Session session(robot(), {});
  EXPECT_THAT(session.resume_if_possible(folder / "none.ckpt"), HasSubstr("cannot be read"));
  session.play();
  EXPECT_TRUE(session.finish().failures.empty());
}

/// A robot that starts again after an update must not wait for somebody who removes a file.
TEST(Session, BeginsAnewIfTheStateOfTheCheckpointCannotBeLoaded) {
  const test::TemporaryFolder folder;
  const std::string command = "set sensors.wheels.speed_noise_m_per_sqrt_s=[0.5, 0.01]";
  Session first(robot_with(command), {.until_s = 2.55});
  first.play();
  first.suspend(folder / "half.ckpt");
  CheckpointIdentity identity;
  const std::string state = read_checkpoint(folder / "half.ckpt", identity);
  Session fresh(robot(), {});
  fresh.play();
  const double whole = x_at_end(fresh);
  for (const std::size_t size : {std::size_t{0}, std::size_t{20}, std::size_t{200}, state.size() / 2}) {
    write_checkpoint(folder / "half.ckpt", identity, std::string_view(state).substr(0, size));
    Session session(live(), {});
    EXPECT_THAT(session.resume_if_possible(folder / "half.ckpt"), HasSubstr("half.ckpt")) << size;
    for (int k = 0; k < kTwists; ++k) session.add(twist(k));
    EXPECT_EQ(x_at_end(session), whole) << size;
  }
}

TEST(Session, RefusesACheckpointThatIsMissing) {
  Session session(robot(), {});
  EXPECT_THROW(session.resume("/nonexistent/half.ckpt"), Error);
}

TEST(Session, TakesMeasurementsThatTheProgramAdds) {
  Session played(robot(), {});
  played.play();
  played.finish();
  Session session(live(), {});
  for (int k = 0; k < kTwists; ++k) session.add(twist(k));
  const SessionResult result = session.finish();
  EXPECT_THAT(result.failures, IsEmpty());
  EXPECT_EQ(x_at_end(session), x_at_end(played));
}

TEST(Session, HasNothingToPlayWithoutASource) {
  Session session(live(), {});
  session.play();
  EXPECT_EQ(session.finish().log_error, "the robot has no source to read measurements from");
}

TEST(Session, NamesWhatTheFilterWaitedFor) {
  Session session(live("{ sensors: [{ name: wheels, plugin: odometry, model: twist }, "
                       "{ name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0], sigma_m: 1 }] }"),
                  {});
  for (int k = 0; k < kTwists; ++k) session.add(twist(k));
  const SessionResult result = session.finish();
  EXPECT_FALSE(result.started);
  ASSERT_EQ(result.failures.size(), 1u);
  EXPECT_EQ(result.failures.front().substr(0, 3), "at ");
}

}  // namespace
}  // namespace waymark::host
