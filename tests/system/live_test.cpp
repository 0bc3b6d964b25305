// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, diagnostics, feature_map, landmarks, map_files, mcap, odometry, recorder, simulator, tum
// A running robot: a simulated one whose measurements arrive as they would, commands, checkpoints, and its end.
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <future>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/system/command.hpp"
#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

/// The robot of config/quickstart.yaml in real time, with a socket for commands.
class LiveRobot {
 public:
  std::filesystem::path file(const char* name) const { return folder_ / name; }
  std::filesystem::path out() const { return folder_ / "out"; }
  std::string socket() const { return file("ctl").string(); }

  Command command(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"run",   WAYMARK_SOURCE_DIR "/config/quickstart.yaml",
                                       "--out", out().string(),
                                       "--set", "live.real_time=true",
                                       "--set", "live.control=" + socket(),
                                       "--set", "filter.particles=5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Command(std::move(arguments));
  }
  Outcome ctl(std::vector<std::string> words) const {
    words.insert(words.begin(), {"ctl", socket()});
    return waymark(words);
  }
  /// True once the filter has started.
  bool is_under_way() const {
    if (!std::filesystem::exists(socket())) return false;
    const Outcome status = ctl({"status"});
    return status.exit_code == 0 && nlohmann::json::parse(status.out)["started"] == true;
  }

 private:
  TemporaryFolder folder_;
};

void wait_until(const std::function<bool()>& ready) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!ready() && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ASSERT_TRUE(ready());
}

TEST(Live, ASignalEndsItWithItsResultsAndNothingIsLost) {
  const LiveRobot robot;
  const Outcome outcome = robot.command().send(SIGTERM, [&] { return robot.is_under_way(); }).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.errors(), SizeIs(0));
  EXPECT_TRUE(has_complete_lines(robot.out() / "trajectory.txt", 1));
  EXPECT_FALSE(std::filesystem::exists(robot.socket()));
  const nlohmann::json report = nlohmann::json::parse(read_text(robot.out() / "diagnostics.json"));
  for (const nlohmann::json& stream : report["live"]["streams"]) EXPECT_EQ(stream["dropped"], 0);
  EXPECT_GT(report["live"]["streams"][0]["received"], 0);
}

TEST(Live, ObeysCommandsAndAnswersThem) {
  const LiveRobot robot;
  auto run = std::async(std::launch::async, [&] { return robot.command().run(); });
  wait_until([&] { return robot.is_under_way(); });

  EXPECT_EQ(robot.ctl({"disable", "gps"}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(robot.ctl({"status"}).out)["sensors"]["gps"]["mode"], "off");
  EXPECT_EQ(robot.ctl({"shadow", "gps"}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(robot.ctl({"status"}).out)["sensors"]["gps"]["mode"], "shadow");
  EXPECT_TRUE(reports_error(robot.ctl({"disable", "gsp"}), 1, {"there is no sensor or map \"gsp\"", "gps", "pillars"}));
  EXPECT_EQ(robot.ctl({"disable", "pillars"}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(robot.ctl({"status"}).out)["maps"]["pillars"]["mode"], "off");
  EXPECT_EQ(robot.ctl({"enable", "pillars"}).exit_code, 0);
  EXPECT_TRUE(reports_error(robot.ctl({"shadow", "pillars"}), 1, {"a map is on or off"}));
  EXPECT_EQ(robot.ctl({"set", "sensors.gps.sigma_m=0.5"}).exit_code, 0);
  EXPECT_EQ(robot.ctl({"set", "maps.pillars.noise.range_m=0.05"}).exit_code, 0);
  EXPECT_TRUE(reports_error(robot.ctl({"set", "sensors.gps.sigm_m=0.5"}), 1, {"sigm_m", "did you mean \"sigma_m\"?"}));
  EXPECT_TRUE(reports_error(robot.ctl({"set", "filter.particles=5"}), 1, {"sensors.NAME.KEY=VALUE"}));
  EXPECT_TRUE(reports_error(robot.ctl({"dropped", "gps", "1"}), 1, {"unknown command"}));
  EXPECT_EQ(robot.ctl({"set-pose", "1", "2", "90"}).exit_code, 0);
  EXPECT_TRUE(reports_error(robot.ctl({"set-pose", "1", "x", "90"}), 1, {"\"x\" is not a number"}));
  EXPECT_TRUE(reports_error(robot.ctl({"statsu"}), 1, {"unknown command", "did you mean \"status\"?"}));
  EXPECT_EQ(robot.ctl({"save-maps"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(robot.out() / "maps" / "pillars.landmarks.yaml"));
  EXPECT_EQ(robot.ctl({"checkpoint"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(robot.out() / "live.ckpt"));
  EXPECT_EQ(robot.ctl({"stop"}).exit_code, 0);

  const Outcome outcome = run.get();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("command: disable gps"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("command: status")));
}

/// What a report shows, but for what the clock of the computer decides: latencies, and that nothing arrives.
std::string repeatable(const std::string& page) {
  nlohmann::json data = nlohmann::json::parse(report_data(page));
  data.erase("live");
  data.erase("events");
  return data.dump();
}

/// The names of the files in which two folders differ, but for what the clock of the computer decides, and those that
/// hold the configuration.
std::vector<std::string> differences(const std::filesystem::path& one, const std::filesystem::path& other) {
  std::vector<std::string> differ;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(one)) {
    const std::string name = std::filesystem::relative(entry.path(), one).string();
    const bool is_compared = entry.is_regular_file() && name != "diagnostics.json" && name != "config.yaml" &&
                             name != ".waymark_files" && name != "flight.mcap" && !name.starts_with("maps/");
    if (!is_compared) continue;
    const bool is_same = name == "report.html"
                             ? std::filesystem::exists(other / name) &&
                                   repeatable(read_text(entry.path())) == repeatable(read_text(other / name))
                             : read_text(entry.path()) == read_text(other / name);
    if (!is_same) differ.push_back(name);
  }
  return differ;
}

TEST(Live, TheFlightRecordReplaysTheRunWithItsCommandsToTheByte) {
  const LiveRobot robot;
  const std::vector<std::string> record{"--set", "record={}"};
  auto run = std::async(std::launch::async, [&] { return robot.command(record).run(); });
  wait_until([&] { return robot.is_under_way(); });
  const std::vector<std::vector<std::string>> commands{{"shadow", "gps"},
                                                       {"set", "sensors.gps.sigma_m=0.5"},
                                                       {"disable", "pillars"},
                                                       {"enable", "gps"},
                                                       {"set-pose", "1", "0", "5"},
                                                       {"enable", "pillars"},
                                                       {"set", "maps.pillars.noise.range_m=0.05"}};
  for (const std::vector<std::string>& words : commands) {
    // Some measurements between two commands.
    const auto arrived = [&] { return nlohmann::json::parse(robot.ctl({"status"}).out)["measurements"].get<int>(); };
    const int before = arrived();
    wait_until([&] { return arrived() > before + 15; });
    EXPECT_EQ(robot.ctl(words).exit_code, 0) << words.front();
  }
  EXPECT_EQ(robot.ctl({"stop"}).exit_code, 0);
  EXPECT_EQ(run.get().exit_code, 0);

  const auto replay = robot.file("replay");
  const Outcome outcome =
      waymark({"run", (robot.out() / "flight.mcap").string(), "--out", replay.string(), "--threads", "1"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(has_complete_lines(replay / "trajectory.txt", 100));
  EXPECT_THAT(differences(robot.out(), replay), SizeIs(0));
  EXPECT_THAT(differences(replay, robot.out()), SizeIs(0));
  EXPECT_FALSE(std::filesystem::exists(replay / "flight.mcap")) << "it is not recorded again";
}

TEST(Live, AnMcapThatIsNoFlightRecordIsRefused) {
  const TemporaryFolder folder;
  write_text(folder / "other.mcap", "rubbish");
  EXPECT_TRUE(reports_error(waymark({"run", (folder / "other.mcap").string(), "--out", (folder / "out").string()}), 1,
                            {"other.mcap"}));
}

TEST(Live, ARestartOnTheSavedMapContinuesIt) {
  const LiveRobot robot;
  auto run = std::async(std::launch::async, [&] { return robot.command().run(); });
  wait_until([&] { return robot.is_under_way(); });
  const auto landmarks = [](const std::filesystem::path& csv) { return lines_of(read_text(csv)).size(); };
  const auto map = robot.out() / "maps" / "pillars.landmarks.yaml";
  wait_until(
      [&] { return robot.ctl({"save-maps"}).exit_code == 0 && read_text(map).find("east_m") != std::string::npos; });
  EXPECT_EQ(robot.ctl({"stop"}).exit_code, 0);
  EXPECT_EQ(run.get().exit_code, 0);
  const std::size_t before = landmarks(robot.out() / "landmarks.csv");
  std::filesystem::copy_file(map, robot.file("kept.landmarks.yaml"));

  const Outcome again = robot
                            .command({"--set", "maps.pillars.load=" + robot.file("kept.landmarks.yaml").string(),
                                      "--set", "maps.pillars.mode=continue"})
                            .send(SIGTERM, [&] { return robot.is_under_way(); })
                            .run();
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_GE(landmarks(robot.out() / "landmarks.csv"), before);
}

TEST(Live, GoesOnFromItsCheckpointAfterItWasKilled) {
  const LiveRobot robot;
  const std::vector<std::string> every{"--set", "live.checkpoint={every_s: 0.2}"};
  const auto checkpoint = robot.out() / "live.ckpt";
  const Outcome killed = robot.command(every).send(SIGKILL, [&] { return std::filesystem::exists(checkpoint); }).run();
  EXPECT_EQ(killed.exit_code, 128 + SIGKILL);
  std::filesystem::copy_file(checkpoint, robot.file("kept.ckpt"));

  std::vector<std::string> again = every;
  again.insert(again.end(), {"--resume", robot.file("kept.ckpt").string()});
  const Outcome outcome = robot.command(again).send(SIGTERM, [&] { return robot.is_under_way(); }).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(has_complete_lines(robot.out() / "trajectory.txt", 1));
}

TEST(Live, ARunBeginsAtItsOwnCheckpointIfItMay) {
  const LiveRobot robot;
  const std::vector<std::string> every{"--set", "live.checkpoint={every_s: 0.2, resume: true}"};
  const auto checkpoint = robot.out() / "live.ckpt";
  const Outcome killed = robot.command(every).send(SIGKILL, [&] { return std::filesystem::exists(checkpoint); }).run();
  EXPECT_THAT(killed.err, HasSubstr("begins anew: "));
  // The measurements before the checkpoint count: of the second run alone none has arrived yet.
  int first_status = 0;
  const auto has_status = [&] {
    const Outcome status = std::filesystem::exists(robot.socket()) ? robot.ctl({"status"}) : Outcome{};
    if (status.exit_code == 0) first_status = nlohmann::json::parse(status.out)["measurements"].get<int>();
    return status.exit_code == 0;
  };
  const Outcome outcome = robot.command(every).send(SIGTERM, has_status).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, Not(HasSubstr("begins anew: ")));
  EXPECT_GT(first_status, 0);
  const nlohmann::json report = nlohmann::json::parse(read_text(robot.out() / "diagnostics.json"));
  std::uint64_t received = 0;
  for (const nlohmann::json& stream : report["live"]["streams"]) received += stream["received"].get<std::uint64_t>();
  std::uint64_t measurements = 0;
  for (const nlohmann::json& sensor : report["sensors"]) measurements += sensor["measurements"].get<std::uint64_t>();
  EXPECT_GT(measurements, received);
}

TEST(Live, PrintsAsMuchAsTheLevelSays) {
  const LiveRobot robot;
  const auto run = [&](const char* level) {
    return robot.command({"--log-level", level}).send(SIGTERM, [&] { return robot.is_under_way(); }).run().err;
  };
  EXPECT_EQ(run("error"), "");
  EXPECT_THAT(run("info"), HasSubstr("results in"));
  EXPECT_THAT(run("warning"), Not(HasSubstr("results in")));
  EXPECT_EQ(waymark({"run", "robot.yaml", "--log-level", "loud"}).exit_code, 2);
}

/// How often `part` is in `text`.
std::size_t count_of(std::string_view part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Live, PrintsAnEventOfTheFilterOnce) {
  const LiveRobot robot;
  const Outcome outcome =
      robot.command({"--set", "source.wheels.nan_probability=0.1", "--set", "source.duration_s=5"}).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(count_of("(further ones are only counted)", outcome.err), 1U) << outcome.err;
}

/// Only a run that is killed shows what was printed before its end.
TEST(Live, PrintsAnEventOfTheFilterWhenItHappens) {
  const LiveRobot robot;
  const auto has_more_than_one_second = [&] {
    if (!robot.is_under_way()) return false;
    return nlohmann::json::parse(robot.ctl({"status"}).out)["measurements"] > 100;
  };
  const Outcome outcome =
      robot.command({"--set", "source.wheels.nan_probability=0.3"}).send(SIGKILL, has_more_than_one_second).run();
  EXPECT_EQ(outcome.exit_code, 128 + SIGKILL);
  EXPECT_THAT(outcome.err, HasSubstr("(further ones are only counted)"));
}

TEST(Live, TwoRunsDoNotShareASocket) {
  const LiveRobot robot;
  auto run = std::async(std::launch::async, [&] { return robot.command().run(); });
  wait_until([&] { return robot.is_under_way(); });
  const Outcome second =
      waymark({"run", WAYMARK_SOURCE_DIR "/config/quickstart.yaml", "--out", robot.file("other").string(), "--set",
               "live.real_time=true", "--set", "live.control=" + robot.socket()});
  EXPECT_TRUE(reports_error(second, 1, {"live.control", "another run listens there"}));
  EXPECT_EQ(robot.ctl({"stop"}).exit_code, 0);
  EXPECT_EQ(run.get().exit_code, 0);
}

/// The socket on which systemd receives the state of a service.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) : descriptor_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
    if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("cannot bind " + path);
  }
  ~NotifySocket() { ::close(descriptor_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  std::vector<std::string> received() const {
    std::vector<std::string> all;
    std::array<char, 256> buffer{};
    for (ssize_t size = 0; (size = ::recv(descriptor_, buffer.data(), buffer.size(), MSG_DONTWAIT)) > 0;)
      all.emplace_back(buffer.data(), static_cast<std::size_t>(size));
    return all;
  }

 private:
  int descriptor_;
};

TEST(Live, ReportsToSystemd) {
  const LiveRobot robot;
  const std::string path = robot.file("notify").string();
  const NotifySocket socket(path);
  std::vector<std::string> messages;
  const auto receive = [&] { std::ranges::move(socket.received(), std::back_inserter(messages)); };
  const auto alive = [&] { return std::ranges::count(messages, "WATCHDOG=1"); };
  const Outcome outcome = robot.command()
                              .with_environment("NOTIFY_SOCKET", path)
                              .with_environment("WATCHDOG_USEC", "200000")
                              .send(SIGTERM,
                                    [&] {
                                      receive();
                                      return alive() >= 10 && std::ranges::count(messages, "READY=1") > 0;
                                    })
                              .run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  receive();
  EXPECT_THAT(messages, Contains("READY=1").Times(1));
  EXPECT_GE(alive(), 10);
  EXPECT_EQ(messages.back(), "STOPPING=1");
}

TEST(Live, SeveralLogsAreOneRun) {
  const TemporaryFolder folder;
  write_text(folder / "wheels.csv", "t,v,w\n0,1,0\n1,1,0\n2,1,0\n3,1,0\n");
  write_text(folder / "gps.csv", "t,e,n\n0.5,0.5,0\n1.5,1.5,0\n2.5,2.5,0\n");
  write_text(folder / "robot.yaml", R"(
sources:
  - { plugin: csv, files: [{ path: wheels.csv, sensor: wheels, payload: BodyTwist, time: t, columns: { v_x_mps: v, w_z_radps: w } }] }
  - { plugin: csv, files: [{ path: gps.csv, sensor: gps, payload: GnssFix, time: t, columns: { east_m: e, north_m: n } }] }
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: twist }
  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.3 }
sinks: [{ plugin: tum }, { plugin: diagnostics }]
)");
  const Outcome outcome = waymark({"run", (folder / "robot.yaml").string(), "--out", (folder / "out").string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json report = nlohmann::json::parse(read_text(folder / "out/diagnostics.json"));
  EXPECT_EQ(report["sensors"][0]["fused"], 4);
  EXPECT_EQ(report["sensors"][1]["fused"], 3);
}

}  // namespace
}  // namespace waymark::system_test
