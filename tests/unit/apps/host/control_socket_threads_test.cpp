// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <boost/asio.hpp>
#include <chrono>
#include <filesystem>
#include <future>
#include <string>
#include <thread>
#include <utility>

#include "control_socket.hpp"
#include "temporary_folder.hpp"

namespace waymark::host {
namespace {

using Protocol = boost::asio::local::stream_protocol;

/// A control socket in a folder of its own, that waits for one command.
class Control {
 public:
  Protocol::endpoint endpoint() const { return Protocol::endpoint((folder_ / "ctl").string()); }

  /// Sends the command and answers it; what the peer gets.
  std::string ask(Protocol::socket& peer, const std::string& line) {
    boost::asio::write(peer, boost::asio::buffer(line + "\n"));
    socket_.reply(kNumber, "ok " + command_.get_future().get());
    std::string answer;
    boost::asio::read_until(peer, boost::asio::dynamic_buffer(answer), '\n');
    return answer;
  }

 private:
  static constexpr std::uint64_t kNumber = 7;

  test::TemporaryFolder folder_;
  std::promise<std::string> command_;
  ControlSocket socket_{folder_ / "ctl", [this](std::string text) {
                          command_.set_value(std::move(text));
                          return kNumber;
                        }};
};

/// As long as it lives, no file can be opened.
class NoDescriptors {
 public:
  NoDescriptors() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const int lowest_free = ::dup(STDERR_FILENO);
    ::close(lowest_free);
    rlimit none = before_;
    none.rlim_cur = static_cast<rlim_t>(lowest_free);
    ::setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;

 private:
  rlimit before_{};
};

TEST(ControlSocket, AnswersAgainAfterFilesHadRunOut) {
  Control control;
  boost::asio::io_context context;
  Protocol::socket peer(context);
  peer.open();
  {
    const NoDescriptors none;
    peer.connect(control.endpoint());
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  EXPECT_EQ(control.ask(peer, "status"), "ok status\n");
}

TEST(ControlSocket, IsForTheSameUserOnly) {
  const Control control;
  EXPECT_EQ(std::filesystem::status(control.endpoint().path()).permissions(), std::filesystem::perms(0600));
}

TEST(ControlSocket, APeerThatSendsAnEndlessLineIsLeftAndOthersAreAnswered) {
  Control control;
  boost::asio::io_context context;
  Protocol::socket flood(context);
  flood.connect(control.endpoint());
  boost::system::error_code error;
  boost::asio::write(flood, boost::asio::buffer(std::string(1 << 20, 'x')), error);
  EXPECT_TRUE(error) << "it is closed";
  Protocol::socket peer(context);
  peer.connect(control.endpoint());
  EXPECT_EQ(control.ask(peer, "status"), "ok status\n");
}

}  // namespace
}  // namespace waymark::host
