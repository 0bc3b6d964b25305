// SPDX-License-Identifier: Apache-2.0
#include "plugins/sources/nmea/line_stream.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <string>

#include "temporary_folder.hpp"

namespace waymark::nmea {
namespace {

extern "C" void on_alarm(int) {}

/// Sends a signal soon, as Ctrl-C would: handled, and no system call is restarted.
class Alarm {
 public:
  Alarm() {
    struct sigaction action {};
    action.sa_handler = on_alarm;
    sigaction(SIGALRM, &action, &before_);
    const itimerval soon{{0, 50'000}, {0, 50'000}};  // again and again: one may come before the wait
    setitimer(ITIMER_REAL, &soon, nullptr);
  }
  ~Alarm() {
    const itimerval never{};
    setitimer(ITIMER_REAL, &never, nullptr);
    sigaction(SIGALRM, &before_, nullptr);
  }
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

 private:
  struct sigaction before_ {};
};

class LineStreamSignal : public testing::Test {
 protected:
  /// Reads until there is nothing more; fails if that takes as long as the patience.
  void expect_end(LineStream& stream, int lines) {
    const auto start = std::chrono::steady_clock::now();
    std::string line;
    for (int i = 0; i < lines; ++i) EXPECT_TRUE(stream.next(line));
    const Alarm alarm;
    EXPECT_FALSE(stream.next(line));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
  }

  test::TemporaryFolder folder_;
};

TEST_F(LineStreamSignal, EndsTheWaitForAWriter) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  LineStream stream(pipe, Duration::zero());
  expect_end(stream, 0);
}

TEST_F(LineStreamSignal, EndsTheWaitForMoreFromAPipe) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int writer = ::open(pipe.c_str(), O_RDWR);
  ASSERT_EQ(::write(writer, "one\ntwo\n", 8), 8);
  LineStream stream(pipe, Duration::zero());
  expect_end(stream, 2);
  ::close(writer);
}

TEST_F(LineStreamSignal, EndsTheWaitForAFileToGrow) {
  const std::string file = folder_ / "log.nmea";
  std::ofstream(file) << "one\n";
  LineStream stream(file, std::chrono::seconds(60));
  expect_end(stream, 1);
}

}  // namespace
}  // namespace waymark::nmea
