// SPDX-License-Identifier: Apache-2.0
// needs plugins: gpsd, nmea
// The source gpsd against a server of the test, and against the real gpsd with gpsfake, if that is installed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <istream>
#include <map>

#include "live_source.hpp"
#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using test::ends_soon;
using test::eventually;
using test::free_port;
using test::LiveReader;
using ::testing::HasSubstr;

std::shared_ptr<Source> make_source(std::uint16_t port, const std::string& more = "") {
  const Config config = Config::parse(fmt::format("gnss: {{ sensor: gps }}\nport: {}\n{}", port, more));
  auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("gpsd", config, Rig({{"gps", "", std::nullopt}}));
  config.reject_unread();
  return source;
}

/// What gpsd would be, for one client.
class FakeGpsd {
 public:
  explicit FakeGpsd(std::uint16_t port) : acceptor_(context_, {asio::ip::address_v4::loopback(), port}) {}

  /// Waits for the client; its request.
  std::string accept() {
    acceptor_.accept(client_);
    asio::streambuf buffer;
    asio::read_until(client_, buffer, '\n');
    std::istream stream(&buffer);
    std::string request;
    std::getline(stream, request);
    return request;
  }
  void send(const std::string& text) { asio::write(client_, asio::buffer(text)); }
  void send_fix(int second) {
    send(
        fmt::format("{{\"class\":\"TPV\",\"mode\":3,\"time\":\"2019-04-12T00:39:{:02}.000Z\",\"lat\":49.0,\"lon\":8.0,"
                    "\"altHAE\":100.0}}\r\n",
                    second));
  }

 private:
  asio::io_context context_;
  tcp::acceptor acceptor_;
  tcp::socket client_{context_};
};

TEST(Gpsd, AsksForReportsAndDeliversFixes) {
  const std::uint16_t port = free_port(SOCK_STREAM);
  FakeGpsd gpsd(port);
  LiveReader reader(make_source(port, "device: /dev/ttyUSB0"));
  EXPECT_TRUE(reader.source().is_live());
  EXPECT_EQ(gpsd.accept(), R"(?WATCH={"enable":true,"json":true,"device":"/dev/ttyUSB0"};)");
  gpsd.send_fix(1);
  ASSERT_TRUE(reader.wait_for(1)) << "without a report of another time";
  gpsd.send_fix(1);
  gpsd.send_fix(2);
  ASSERT_TRUE(reader.wait_for(2));
  const auto all = reader.measurements();
  EXPECT_EQ(all[0].as<GnssFix>().latitude_deg, 49.0);
  EXPECT_EQ(all[1].stamp - all[0].stamp, std::chrono::seconds(1));
  EXPECT_TRUE(reader.wait_for_event(fmt::format("gpsd 127.0.0.1:{}: connected", port)));
}

TEST(Gpsd, StopsWithinATenthOfASecond) {
  EXPECT_TRUE(ends_soon([] {
    const std::uint16_t port = free_port(SOCK_STREAM);
    FakeGpsd gpsd(port);
    LiveReader reader(make_source(port));
    gpsd.accept();
    gpsd.send_fix(1);
    EXPECT_TRUE(reader.wait_for(1));
    return reader.stop();
  }));
}

TEST(Gpsd, ComesBackWhenGpsdDoes) {
  const std::uint16_t port = free_port(SOCK_STREAM);
  LiveReader reader(make_source(port));
  EXPECT_TRUE(reader.wait_for_event("not reached: Connection refused; it is tried again"));
  {
    FakeGpsd gpsd(port);
    gpsd.accept();
    gpsd.send_fix(1);
    ASSERT_TRUE(reader.wait_for(1));
    gpsd.send("{\"class\":\"TPV\",\"mo");
  }
  EXPECT_TRUE(reader.wait_for_event("lost: "));
  FakeGpsd gpsd(port);
  gpsd.accept();
  EXPECT_TRUE(reader.wait_for_event("restored"));
  gpsd.send_fix(2);
  ASSERT_TRUE(reader.wait_for(2));
}

TEST(Gpsd, StopsWithinATenthOfASecondAlsoWithoutGpsd) {
  EXPECT_TRUE(ends_soon([] {
    LiveReader without(make_source(free_port(SOCK_STREAM)));
    EXPECT_TRUE(without.wait_for_event("not reached"));
    return without.stop();
  }));
  // An address where nobody answers: the attempt to connect waits.
  EXPECT_TRUE(ends_soon([] {
    const Config config = Config::parse("{ gnss: { sensor: gps }, address: 192.0.2.1 }");
    LiveReader waiting(
        PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("gpsd", config, Rig({{"gps", "", std::nullopt}})));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return waiting.stop();
  }));
}

/// The real gpsd, that gpsfake starts and feeds with a log.
class GpsFake {
 public:
  static bool is_installed() {
    return std::system("command -v gpsfake >/dev/null && { command -v gpsd || test -x /usr/sbin/gpsd; } >/dev/null") ==
           0;
  }
  GpsFake(const std::filesystem::path& log, std::uint16_t port, const std::filesystem::path& messages) {
    child_ = ::fork();
    if (child_ != 0) return;
    ::setpgid(0, 0);
    if (std::freopen(messages.c_str(), "a", stdout) == nullptr || ::dup2(STDOUT_FILENO, STDERR_FILENO) < 0)
      ::_exit(126);
    const std::string path = std::string("PATH=") + std::getenv("PATH") + ":/usr/sbin";
    ::putenv(const_cast<char*>(path.c_str()));
    ::execlp("gpsfake", "gpsfake", "-c", "0.01", "-1", "-q", "-P", std::to_string(port).c_str(), log.c_str(), nullptr);
    ::_exit(127);
  }
  ~GpsFake() { end(); }
  GpsFake(const GpsFake&) = delete;
  GpsFake& operator=(const GpsFake&) = delete;

  /// Ends gpsfake and its gpsd.
  void end() {
    if (child_ <= 0) return;
    ::kill(-child_, SIGTERM);
    int status = 0;
    if (!eventually([&] { return ::waitpid(child_, &status, WNOHANG) == child_; }, std::chrono::seconds(10))) {
      ::kill(-child_, SIGKILL);
      ::waitpid(child_, &status, 0);
    }
    child_ = -1;
  }

 private:
  pid_t child_ = -1;
};

class RealGpsd : public ::testing::Test {
 protected:
  void SetUp() override {
    // It starts daemons and waits for them by the clock, which a loaded machine does not keep.
    if (std::getenv("WAYMARK_TEST_GPSD") == nullptr) GTEST_SKIP() << "WAYMARK_TEST_GPSD is not set";
    if (!GpsFake::is_installed()) GTEST_SKIP() << "gpsd or gpsfake is not installed";
  }

  static std::string sentence(const std::string& body) {
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    return fmt::format("${}*{:02X}\r\n", body, sum);
  }
  /// A robot that drives north at 1 m/s, once a second, in 2024.
  std::filesystem::path write_log(int seconds) const {
    std::ofstream out(folder_ / "drive.nmea", std::ios::binary);
    out << "# invented\r\n";
    for (int k = 0; k < seconds; ++k) {
      const std::string time = fmt::format("12{:02}{:02}.00", k / 60, k % 60);
      const std::string latitude = fmt::format("49{:08.5f}", 30.0 + k / 1852.0);
      out << sentence("GPRMC," + time + ",A," + latitude + ",N,00830.00000,E,1.944,0.0,010624,,,D");
      out << sentence("GPGGA," + time + "," + latitude + ",N,00830.00000,E,2,09,0.9,110.0,M,47.0,M,,");
      out << sentence("GPGSA,A,3,02,05,07,09,13,16,20,29,30,,,,1.6,0.9,1.3");
      out << sentence("GPGST," + time + ",5.0,2.0,1.0,0.0,0.6,0.8,1.5");
    }
    return folder_ / "drive.nmea";
  }
  test::TemporaryFolder folder_;
};

TEST_F(RealGpsd, DeliversEachEpochOnceWithItsSigmas) {
  const std::uint16_t port = free_port(SOCK_STREAM);
  const GpsFake gpsfake(write_log(60), port, folder_ / "messages");
  LiveReader reader(make_source(port));
  ASSERT_TRUE(reader.wait_for(30)) << folder_.read("messages");
  reader.stop();
  const auto all = reader.measurements();
  int with_sigmas = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& fix = all[i].as<GnssFix>();
    EXPECT_EQ(fix.problem(), "");
    EXPECT_EQ(fix.type, GnssFix::Type::differential);
    EXPECT_NEAR(fix.height_m, 157.0, 0.01);
    if (i > 0) {
      EXPECT_GT(all[i].stamp, all[i - 1].stamp);
      EXPECT_NEAR((fix.latitude_deg - all[i - 1].as<GnssFix>().latitude_deg) * 60.0 * 1852.0,
                  to_seconds(all[i].stamp - all[i - 1].stamp), 0.05);
    }
    if (std::isnan(fix.sigma_horizontal_m)) continue;
    ++with_sigmas;
    EXPECT_NEAR(fix.sigma_horizontal_m, std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(fix.sigma_vertical_m, 1.5, 1e-6);
  }
  EXPECT_GT(with_sigmas, 25);
}

TEST_F(RealGpsd, SurvivesARestart) {
  const std::uint16_t port = free_port(SOCK_STREAM);
  const std::filesystem::path log = write_log(3000);
  LiveReader reader(make_source(port));
  GpsFake first(log, port, folder_ / "messages");
  ASSERT_TRUE(reader.wait_for(5)) << folder_.read("messages");
  first.end();
  EXPECT_TRUE(reader.wait_for_event("lost: "));
  const std::size_t before = reader.measurements().size();
  const GpsFake second(log, port, folder_ / "messages");
  EXPECT_TRUE(reader.wait_for_event("restored")) << folder_.read("messages");
  EXPECT_TRUE(reader.wait_for(before + 5)) << folder_.read("messages");
}

TEST_F(RealGpsd, AgreesWithTheSourceNmeaOnRealReceivers) {
  const char* data = std::getenv("WAYMARK_DATA");
  if (data == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const PluginLoader loader({WAYMARK_PLUGIN_DIR});
  for (const char* name : {"skytraq-dgps", "ublox-zed-f9p-nmea", "sirfstarv-nmea"}) {
    const std::filesystem::path log = std::filesystem::path(data) / "nmea_receivers" / (std::string(name) + ".nmea");
    if (!std::filesystem::exists(log)) GTEST_SKIP() << log << " is not there";
    std::map<Time, GnssFix> expected;
    const auto nmea =
        loader.create<Source>("nmea", Config::parse("{ file: " + log.string() + ", gnss: { sensor: gps } }"),
                              Rig({{"gps", "", std::nullopt}}));
    while (auto m = nmea->next()) expected.emplace(m->stamp, m->as<GnssFix>());

    const std::uint16_t port = free_port(SOCK_STREAM);
    LiveReader reader(make_source(port));
    {
      const GpsFake gpsfake(log, port, folder_ / "messages");
      ASSERT_TRUE(reader.wait_for_event("connected")) << name << folder_.read("messages");
      reader.wait_for_event("lost");  // gpsfake ends with the log
    }
    reader.stop();
    std::size_t compared = 0;
    for (const Measurement& m : reader.measurements()) {
      // From a log, gpsd moves the date of some receivers into the 1024 weeks around today.
      auto match = expected.find(m.stamp);
      if (match == expected.end()) match = expected.find(m.stamp - std::chrono::weeks(1024));
      const auto& fix = m.as<GnssFix>();
      if (match == expected.end() || fix.type == GnssFix::Type::none) continue;
      ++compared;
      // gpsd writes nine decimals, about 0.1 mm.
      EXPECT_NEAR(fix.latitude_deg, match->second.latitude_deg, 2e-9) << name;
      EXPECT_NEAR(fix.longitude_deg, match->second.longitude_deg, 2e-9) << name;
      EXPECT_EQ(fix.type, match->second.type) << name;
      if (!std::isnan(fix.sigma_horizontal_m) && !std::isnan(match->second.sigma_horizontal_m)) {
        EXPECT_NEAR(fix.sigma_horizontal_m, match->second.sigma_horizontal_m, 1e-3) << name;
      }
    }
    EXPECT_GT(compared, expected.size() / 2) << name << ": of " << expected.size();
  }
}

}  // namespace
}  // namespace waymark
