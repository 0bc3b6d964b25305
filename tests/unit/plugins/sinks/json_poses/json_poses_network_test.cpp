// SPDX-License-Identifier: Apache-2.0
// The sink json_poses at sockets: clients that read, that do not, and that go.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <istream>
#include <nlohmann/json.hpp>

#include "live_source.hpp"
#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using test::eventually;
using test::FakeSnapshot;
using test::free_port;
using test::make_sink;
using test::TemporaryFolder;
using ::testing::HasSubstr;

class JsonPosesNetwork : public ::testing::Test {
 protected:
  void start(const std::string& yaml) {
    sink_ = make_sink("json_poses", yaml);
    sink_->start({out_.path(), nullptr, nullptr});
  }
  void write(double x) {
    snapshot_.at(x, Pose::planar(x, 0.0, 0.0));
    sink_->write(snapshot_);
  }
  bool wait_for_event(const std::string& text) {
    return eventually([&] {
      for (std::string& event : sink_->take_events()) events_ += event + "\n";
      return events_.find(text) != std::string::npos;
    });
  }
  /// x of the next line.
  template <class Socket>
  double next_x(Socket& socket) {
    boost::system::error_code error;
    asio::read_until(socket, received_, '\n', error);
    if (error) return -1.0;
    std::istream stream(&received_);
    std::string line;
    std::getline(stream, line);
    return nlohmann::json::parse(line).at("x_m").get<double>();
  }

  TemporaryFolder out_;
  asio::io_context context_;
  asio::streambuf received_;
  std::shared_ptr<Sink> sink_;
  FakeSnapshot snapshot_;
  std::string events_;
};

TEST_F(JsonPosesNetwork, SendsADatagramForEachLine) {
  udp::socket receiver(context_, udp::endpoint(asio::ip::address_v4::loopback(), 0));
  start(fmt::format("{{ to: udp, port: {} }}", receiver.local_endpoint().port()));
  for (const double x : {1.0, 2.0}) {
    write(x);
    std::array<char, 4096> buffer{};
    const std::size_t count = receiver.receive(asio::buffer(buffer));
    EXPECT_EQ(nlohmann::json::parse(std::string(buffer.data(), count)).at("x_m"), x);
  }
  sink_->finish(&snapshot_, {});
  EXPECT_TRUE(sink_->take_events().empty());
}

TEST_F(JsonPosesNetwork, ADestinationThatCannotBeReachedIsReportedOnce) {
  start("{ to: udp, address: 255.255.255.255, port: 9 }");  // refused: the socket may not broadcast
  for (int i = 0; i < 1000; ++i) write(i);
  sink_->finish(&snapshot_, {});
  EXPECT_TRUE(wait_for_event("udp 255.255.255.255:9: lost: "));
  EXPECT_TRUE(wait_for_event("1000 lines were left out"));
}

TEST_F(JsonPosesNetwork, SendsToEveryClientOfATcpPort) {
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), free_port(SOCK_STREAM));
  start(fmt::format("{{ to: tcp, port: {} }}", endpoint.port()));
  write(1.0);  // nobody is there
  tcp::socket one(context_);
  tcp::socket two(context_);
  one.connect(endpoint);
  two.connect(endpoint);
  const std::string name = fmt::format("connected: 127.0.0.1:{}", two.local_endpoint().port());
  ASSERT_TRUE(wait_for_event(name)) << events_;
  write(2.0);
  EXPECT_EQ(next_x(one), 2.0);
  EXPECT_EQ(next_x(two), 2.0);
  two.close();
  EXPECT_TRUE(wait_for_event("after 1 lines; 0 were left out: it closed the connection")) << events_;
  write(3.0);
  EXPECT_EQ(next_x(one), 3.0);
  sink_->finish(&snapshot_, {});
  EXPECT_EQ(next_x(one), -1.0) << "the end";
}

TEST_F(JsonPosesNetwork, AClientThatDoesNotReadLosesTheOldestLinesAndDelaysNobody) {
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), free_port(SOCK_STREAM));
  start(fmt::format("{{ to: tcp, port: {}, max_waiting_lines: 10 }}", endpoint.port()));
  tcp::socket slow(context_);
  slow.open(tcp::v4());
  slow.set_option(asio::socket_base::receive_buffer_size(4096));
  slow.connect(endpoint);
  ASSERT_TRUE(wait_for_event("connected"));
  constexpr int kLines = 50'000;
  for (int i = 0; i < kLines; ++i) write(i);  // would never end if it waited for the client
  EXPECT_TRUE(wait_for_event("reads too slowly: the oldest lines are left out")) << events_;
  std::atomic<double> newest = -1.0;
  int lines = 0;
  std::thread reader([&] {
    for (double x = next_x(slow); x >= 0.0; x = next_x(slow)) {
      EXPECT_GT(x, newest);
      newest = x;
      ++lines;
    }
  });
  EXPECT_TRUE(eventually([&] { return newest == kLines - 1; })) << "the newest line is there";
  sink_->finish(&snapshot_, {});
  sink_.reset();
  reader.join();
  EXPECT_LT(lines, kLines);
}

TEST_F(JsonPosesNetwork, AUnixSocketIsForItsOwnerOnly) {
  start("{ to: unix }");
  const std::string path = out_ / "poses.sock";
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  asio::local::stream_protocol::socket client(context_);
  client.connect(asio::local::stream_protocol::endpoint(path));
  ASSERT_TRUE(wait_for_event("connected: client"));
  write(5.0);
  EXPECT_EQ(next_x(client), 5.0);
  sink_->finish(&snapshot_, {});
  EXPECT_FALSE(out_.has("poses.sock"));
}

TEST_F(JsonPosesNetwork, APortOfAnotherProgramIsAnError) {
  tcp::acceptor other(context_, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  try {
    start(fmt::format("{{ to: tcp, port: {} }}", other.local_endpoint().port()));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot be listened at: Address already in use"));
  }
}

TEST_F(JsonPosesNetwork, FrontAndCommittedMayComeFromTwoThreads) {
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), free_port(SOCK_STREAM));
  start(fmt::format("{{ to: tcp, port: {}, when: front }}", endpoint.port()));
  tcp::socket client(context_);
  client.connect(endpoint);
  ASSERT_TRUE(wait_for_event("connected"));
  write(0.0);
  std::thread outputs([&] {
    FakeSnapshot front;
    for (int i = 1; i <= 200; ++i) sink_->front(front.at(i, Pose::planar(i, 0.0, 0.0)).belief_);
  });
  for (int i = 0; i < 200; ++i) write(i);
  for (int i = 1; i <= 200; ++i) EXPECT_EQ(next_x(client), i);
  outputs.join();
  sink_->finish(&snapshot_, {});
}

}  // namespace
}  // namespace waymark
