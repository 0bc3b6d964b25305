// SPDX-License-Identifier: Apache-2.0
// The source nmea at a serial port, which is a pseudo-terminal here.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <termios.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "live_source.hpp"
#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

using test::LiveReader;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return fmt::format("${}*{:02X}\r\n", body, sum);
}
std::string gga(const std::string& time) {
  return sentence("GPGGA," + time + ",4930.0000,N,00830.6000,E,1,08,1.5,100.0,M,47.5,M,,");
}
std::string rmc(const std::string& time) {
  return sentence("GPRMC," + time + ",A,4930.0000,N,00830.6000,E,10.0,90.0,010124,,,A");
}

/// A receiver at a pseudo-terminal, which the path leads to.
class Receiver {
 public:
  explicit Receiver(const std::filesystem::path& path) : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0)
      throw std::runtime_error("there is no pseudo-terminal");
    std::filesystem::remove(path);
    std::filesystem::create_symlink(::ptsname(master_), path);
  }
  ~Receiver() { unplug(); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  void send(const std::string& text) const {
    ASSERT_EQ(::write(master_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void unplug() {
    if (master_ >= 0) ::close(master_);
    master_ = -1;
  }
  /// As the other end has set it.
  speed_t speed() const {
    termios settings{};
    ::tcgetattr(master_, &settings);
    return ::cfgetispeed(&settings);
  }

 private:
  int master_;
};

class NmeaSerial : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "gps"; }
  std::shared_ptr<Source> make(const std::string& more = "") const {
    const Config config = Config::parse("device: " + path().string() + "\ngnss: { sensor: gps }\n" + more);
    auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("nmea", config, Rig({{"gps", "", std::nullopt}}));
    config.reject_unread();
    return source;
  }
  std::string error_of(const std::string& more) const {
    try {
      make(more);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  static std::vector<std::int64_t> seconds_of_day(const std::vector<Measurement>& all) {
    std::vector<std::int64_t> seconds;
    for (const Measurement& m : all)
      seconds.push_back(std::chrono::duration_cast<std::chrono::seconds>(m.stamp.time_since_epoch()).count() % 86400);
    return seconds;
  }

  test::TemporaryFolder folder_;
};

TEST_F(NmeaSerial, AFixIsDeliveredWhenTheReceiverPauses) {
  const Receiver receiver(path());
  LiveReader reader(make());
  EXPECT_TRUE(reader.source().is_live());
  ASSERT_TRUE(reader.wait_for_event("serial " + path().string() + ": connected"));
  receiver.send(rmc("120000") + gga("120000"));
  ASSERT_TRUE(reader.wait_for(1)) << "without a sentence of the next time";
  receiver.send(gga("120000") + rmc("120001"));
  receiver.send(gga("120001").substr(0, 20));
  receiver.send(gga("120001").substr(20));
  ASSERT_TRUE(reader.wait_for(2));
  reader.stop();
  const auto all = reader.measurements();
  EXPECT_EQ(all.size(), 2U) << "a sentence behind the pause makes no second fix of that time";
  EXPECT_EQ(all[1].as<GnssFix>().satellites, 8);
  EXPECT_NEAR(all[1].as<GnssFix>().speed_mps, 5.144, 1e-3);
  EXPECT_TRUE(reader.source().bad_records().empty());
}

TEST_F(NmeaSerial, SetsTheRate) {
  const Receiver receiver(path());
  LiveReader reader(make("baud: 4800"));
  ASSERT_TRUE(reader.wait_for_event("connected"));
  EXPECT_EQ(receiver.speed(), static_cast<speed_t>(B4800));
}

TEST_F(NmeaSerial, GoesOnWhenTheReceiverIsPluggedInAgain) {
  LiveReader reader(make());
  EXPECT_TRUE(reader.wait_for_event("not reached: No such file or directory; it is tried again"));
  auto receiver = std::make_unique<Receiver>(path());
  ASSERT_TRUE(reader.wait_for_event("connected"));
  receiver->send(rmc("120000") + gga("120000") + rmc("120001").substr(0, 15));
  ASSERT_TRUE(reader.wait_for(1));
  receiver->unplug();
  ASSERT_TRUE(reader.wait_for_event("lost: "));
  receiver = std::make_unique<Receiver>(path());
  ASSERT_TRUE(reader.wait_for_event("restored"));
  receiver->send(rmc("120005") + gga("120005"));
  ASSERT_TRUE(reader.wait_for(2));
  reader.stop();
  EXPECT_THAT(seconds_of_day(reader.measurements()), ElementsAre(43200, 43205));
  EXPECT_TRUE(reader.source().bad_records().empty()) << "what was cut off is forgotten";
}

TEST_F(NmeaSerial, AClockThatIsSetBackIsBelievedTheSecondTime) {
  const Receiver receiver(path());
  LiveReader reader(make());
  ASSERT_TRUE(reader.wait_for_event("connected"));
  receiver.send(rmc("120000") + rmc("130000") + rmc("130001") + rmc("120002") + rmc("120003") + rmc("120004"));
  ASSERT_TRUE(reader.wait_for(5));
  reader.stop();
  EXPECT_THAT(seconds_of_day(reader.measurements()), ElementsAre(43200, 46800, 46801, 43203, 43204));
}

TEST_F(NmeaSerial, RubbishIsReportedAndSkipped) {
  const Receiver receiver(path());
  LiveReader reader(make());
  ASSERT_TRUE(reader.wait_for_event("connected"));
  for (int i = 0; i < 20; ++i) receiver.send("$GPGGA,rubbish\r\n");
  receiver.send(std::string(3000, 'x') + "\r\n" + rmc("120000") + gga("120000"));
  ASSERT_TRUE(reader.wait_for(1));
  EXPECT_TRUE(reader.wait_for_event("10 bad records so far; serial " + path().string() + ", line 10: "));
  reader.stop();
  EXPECT_EQ(reader.source().bad_records().size(), 21U);
}

TEST_F(NmeaSerial, StopsWithinATenthOfASecond) {
  EXPECT_TRUE(test::ends_soon([&] {
    LiveReader reader(make());
    EXPECT_TRUE(reader.wait_for_event("not reached"));
    return reader.stop();
  }));
  const Receiver receiver(path());
  EXPECT_TRUE(test::ends_soon([&] {
    LiveReader reader(make());
    EXPECT_TRUE(reader.wait_for_event("connected"));
    const auto duration = reader.stop();
    EXPECT_FALSE(reader.source().next().has_value());
    return duration;
  }));
}

TEST_F(NmeaSerial, TheYamlIsChecked) {
  EXPECT_THAT(error_of("baud: 5000"), HasSubstr("5000 is not one of: 1200, 2400, 4800"));
  EXPECT_THAT(error_of("file: log.nmea"), HasSubstr("file"));
}

}  // namespace
}  // namespace waymark
