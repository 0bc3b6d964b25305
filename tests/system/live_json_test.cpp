// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, diagnostics, json, json_poses, mcap, odometry, plot, recorder, tum
// config/live_json.yaml as it is shipped, but for its ports: fed by this program, which reads the poses.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <chrono>
#include <csignal>
#include <functional>
#include <future>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "live_source.hpp"
#include "tests/system/command.hpp"

namespace waymark::system_test {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;

/// A robot that drives east at 1 m/s: 50 messages of the wheels and 5 fixes a second, with their times.
class Robot {
 public:
  explicit Robot(std::uint16_t port) : to_(asio::ip::address_v4::loopback(), port), thread_([this] { drive(); }) {}
  ~Robot() {
    ends_ = true;
    thread_.join();
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  /// The messages of the wheels are lost on their way, or not.
  void lose_wheels(bool lost) { loses_wheels_ = lost; }

 private:
  void drive() {
    using namespace std::chrono;
    constexpr double kDegreesPerMetre = 1.0 / 73'000.0;  // at 49° north
    const auto start = steady_clock::now();
    const auto first = duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
    for (int k = 0; !ends_; ++k) {
      const auto stamp = duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
      if (!loses_wheels_)
        send(fmt::format(R"({{"sensor":"wheels","stamp_ns":{},"left_mps":1.0,"right_mps":1.0}})", stamp));
      if (k % 10 == 0) {
        const double x = 1e-9 * static_cast<double>(stamp - first);  // where it was then, however late this is sent
        send(fmt::format(
            R"({{"sensor":"gps","stamp_ns":{},"latitude_deg":49.0,"longitude_deg":{:.9f},"type":"single"}})", stamp,
            8.0 + x * kDegreesPerMetre));
      }
      if (k % 100 == 99) send("rubbish");
      std::this_thread::sleep_until(start + milliseconds(20) * (k + 1));
    }
  }
  void send(const std::string& line) {
    boost::system::error_code nobody_listens_yet;
    socket_.send_to(asio::buffer(line), to_, 0, nobody_listens_yet);
  }

  asio::io_context context_;
  udp::endpoint to_;
  udp::socket socket_{context_, udp::endpoint(asio::ip::address_v4::loopback(), 0)};
  std::atomic<bool> ends_ = false;
  std::atomic<bool> loses_wheels_ = false;
  std::thread thread_;
};

/// Reads poses until the program closes the connection.
class PoseReader {
 public:
  explicit PoseReader(std::uint16_t port) : thread_([this, port] { read(port); }) {}
  ~PoseReader() { join(); }
  PoseReader(const PoseReader&) = delete;
  PoseReader& operator=(const PoseReader&) = delete;

  int count() const { return count_; }
  void join() {
    if (thread_.joinable()) thread_.join();
  }
  const nlohmann::json& first() const { return first_; }  // after join
  const nlohmann::json& last() const { return last_; }

 private:
  void read(std::uint16_t port) {
    asio::io_context context;
    tcp::socket socket(context);
    boost::system::error_code error;
    const bool connected = test::eventually([&] {
      socket.connect({asio::ip::address_v4::loopback(), port}, error);
      if (error) socket.close();
      return !error;
    });
    asio::streambuf received;
    while (connected && !error) {
      asio::read_until(socket, received, '\n', error);
      if (error) break;
      std::istream stream(&received);
      std::string line;
      std::getline(stream, line);
      last_ = nlohmann::json::parse(line);
      if (count_++ == 0) first_ = last_;
    }
  }

  nlohmann::json first_;
  nlohmann::json last_;
  std::atomic<int> count_ = 0;
  std::thread thread_;
};

TEST(LiveJson, TheShippedRobotRunsUntilItIsStopped) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const std::uint16_t in_port = test::free_port(SOCK_DGRAM);
  const std::uint16_t out_port = test::free_port(SOCK_STREAM);
  const Robot robot(in_port);
  PoseReader poses(out_port);
  constexpr int kPoses = 200;  // four seconds
  Command command({"run", WAYMARK_SOURCE_DIR "/config/live_json.yaml", "--out", out.string(), "--set",
                   fmt::format("source.port={}", in_port), "--set", fmt::format("sinks.json_poses.port={}", out_port)});
  const Outcome outcome = command.send(SIGTERM, [&] { return poses.count() >= kPoses; }).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(outcome.errors().empty()) << outcome.err;
  poses.join();
  ASSERT_GE(poses.count(), kPoses) << outcome.err;
  const auto seconds = [](const nlohmann::json& pose) { return 1e-9 * pose.at("stamp_ns").get<double>(); };
  EXPECT_NEAR(poses.last().at("v_x_mps").get<double>(), 1.0, 0.05);
  EXPECT_NEAR(poses.last().at("x_m").get<double>() - poses.first().at("x_m").get<double>(),
              seconds(poses.last()) - seconds(poses.first()), 0.5);
  EXPECT_TRUE(has_complete_lines(out / "trajectory.txt", kPoses));
  EXPECT_TRUE(has_no_partial_file(out));
  const nlohmann::json report = nlohmann::json::parse(read_text(out / "diagnostics.json"));
  EXPECT_GE(report.at("run").at("bad_record_count").get<int>(), 1) << "rubbish is skipped";
}

/// The texts of the events that name missing measurements.
std::vector<std::string> missing_events(const nlohmann::json& report) {
  std::vector<std::string> texts;
  for (const nlohmann::json& event : report.at("run").at("events")) {
    if (event.at("text").get<std::string>().ends_with(" missing")) texts.push_back(event.at("text"));
  }
  return texts;
}

TEST(LiveJson, MessagesThatAreLostOnTheirWayAreReportedAndTheRecordRepeatsThat) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const std::uint16_t in_port = test::free_port(SOCK_DGRAM);
  const std::uint16_t out_port = test::free_port(SOCK_STREAM);
  Robot robot(in_port);
  PoseReader poses(out_port);
  using std::chrono::steady_clock;
  std::optional<steady_clock::time_point> lost_at;
  const auto is_over = [&] {
    if (poses.count() >= 100 && !lost_at) {
      robot.lose_wheels(true);
      lost_at = steady_clock::now();
    }
    if (!lost_at) return false;
    const auto since = steady_clock::now() - *lost_at;
    if (since > std::chrono::seconds(2)) robot.lose_wheels(false);
    return since > std::chrono::seconds(5);
  };
  Command command({"run", WAYMARK_SOURCE_DIR "/config/live_json.yaml", "--out", out.string(), "--set", "record={}",
                   "--set", fmt::format("source.port={}", in_port), "--set",
                   fmt::format("sinks.json_poses.port={}", out_port)});
  const Outcome outcome = command.send(SIGTERM, is_over).run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  poses.join();

  const nlohmann::json report = nlohmann::json::parse(read_text(out / "diagnostics.json"));
  const std::vector<std::string> events = missing_events(report);
  ASSERT_EQ(events.size(), 1U) << report.at("run").at("events");
  EXPECT_THAT(events.front(), testing::StartsWith("wheels: no measurement for 2"));
  EXPECT_THAT(outcome.err, testing::HasSubstr(events.front()));
  for (const nlohmann::json& stream : report.at("live").at("streams")) {
    const double expected = stream.at("sensor") == "wheels" ? 100.0 : 0.0;
    EXPECT_NEAR(stream.at("missing").get<double>(), expected, 0.2 * expected) << stream;
  }
  EXPECT_THAT(report.at("health").dump(), testing::HasSubstr("measurements are missing"));

  const std::filesystem::path again = folder / "again";
  const Outcome replay = Command({"run", out / "flight.mcap", "--out", again}).run();
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  EXPECT_EQ(read_text(again / "trajectory.txt"), read_text(out / "trajectory.txt"));
  const nlohmann::json replayed = nlohmann::json::parse(read_text(again / "diagnostics.json"));
  EXPECT_EQ(missing_events(replayed), events);
  EXPECT_EQ(replayed.at("health"), report.at("health"));
}

/// The shipped robot, to which nobody sends anything. `steer`: called with its control socket; must stop it.
Outcome run_without_measurements(const std::function<void(const std::string& socket)>& steer) {
  const TemporaryFolder folder;
  const std::string control = (folder / "ctl").string();
  Command command({"run", WAYMARK_SOURCE_DIR "/config/live_json.yaml", "--out", (folder / "out").string(), "--set",
                   fmt::format("source.port={}", test::free_port(SOCK_DGRAM)), "--set",
                   fmt::format("sinks.json_poses.port={}", test::free_port(SOCK_STREAM)), "--set",
                   "live.control=" + control});
  auto run = std::async(std::launch::async, [&] { return command.run(); });
  EXPECT_TRUE(test::eventually([&] { return waymark({"ctl", control, "status"}).exit_code == 0; }));
  steer(control);
  return run.get();
}

TEST(LiveJson, ARunThatNeverStartsEndsWithTheReason) {
  const Outcome outcome = run_without_measurements([](const std::string& socket) {
    EXPECT_EQ(waymark({"ctl", socket, "disable", "gps"}).exit_code, 0);  // an event after all measurements
    EXPECT_EQ(waymark({"ctl", socket, "stop"}).exit_code, 0);
  });
  EXPECT_TRUE(reports_error(outcome, 1, {"the filter never started: no measurement has arrived"})) << outcome.err;
  EXPECT_THAT(outcome.errors().back(), testing::Not(testing::HasSubstr("command: disable gps")));
}

TEST(LiveJson, TheStatusSaysThatTheFilterHasNotStarted) {
  run_without_measurements([](const std::string& socket) {
    const nlohmann::json status = nlohmann::json::parse(waymark({"ctl", socket, "status"}).out);
    EXPECT_EQ(status.at("started"), false);
    EXPECT_EQ(status.at("health"), "lost");
    EXPECT_EQ(status.at("reason"), "the filter has not started");
    EXPECT_EQ(waymark({"ctl", socket, "stop"}).exit_code, 0);
  });
}

}  // namespace
}  // namespace waymark::system_test
