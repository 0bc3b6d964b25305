// SPDX-License-Identifier: Apache-2.0
// The source json at sockets and pipes: lines of several programs, faults of theirs, and its end.
#include <sys/stat.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>
#include <random>

#include "json_fixture.hpp"
#include "live_source.hpp"
#include "plugins/sources/json/input_feed.hpp"

namespace waymark::json_test {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using test::ends_soon;
using test::eventually;
using test::free_port;
using test::LiveReader;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

class JsonLive : public Json {
 protected:
  static asio::ip::address loopback() { return asio::ip::address_v4::loopback(); }
  /// Connects as soon as somebody listens.
  template <class Socket, class Endpoint>
  void connect(Socket& socket, const Endpoint& endpoint) {
    ASSERT_TRUE(eventually([&] {
      boost::system::error_code error;
      socket.connect(endpoint, error);
      if (error) socket.close();
      return !error;
    }));
  }
  void send(tcp::socket& socket, const std::string& text) { asio::write(socket, asio::buffer(text)); }

  asio::io_context context_;
};

class JsonUdp : public JsonLive {
 protected:
  /// Repeats until one line has arrived: the port opens in another thread.
  void send_first(const LiveReader& reader, const std::string& text) {
    ASSERT_TRUE(eventually([&] {
      boost::system::error_code refused;
      socket_.send_to(asio::buffer(text), endpoint_, 0, refused);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      return !reader.measurements().empty();
    }));
  }
  void send(const std::string& text) { socket_.send_to(asio::buffer(text), endpoint_); }
  std::string yaml() const { return fmt::format("from: udp\nport: {}", endpoint_.port()); }

  udp::endpoint endpoint_{loopback(), free_port(SOCK_DGRAM)};
  udp::socket socket_{context_, udp::endpoint(loopback(), 0)};
};

TEST_F(JsonUdp, ReadsTheLinesOfDatagrams) {
  LiveReader reader(make(yaml()));
  EXPECT_TRUE(reader.source().is_live());
  EXPECT_LT(reader.source().progress(), 0.0);
  send_first(reader, wheels(0));
  const std::size_t before = reader.measurements().size();
  send(wheels(1) + wheels(2, ",\"stamp\":5") + R"({"sensor":"gps","east_m":1,"north_m":2})");
  ASSERT_TRUE(reader.wait_for(before + 3));
  const auto all = reader.measurements();
  const auto& last = all.back();
  EXPECT_EQ(last.sensor, 1U);
  EXPECT_EQ(last.stamp, kUnknownStamp);
  EXPECT_EQ(all[before + 1].stamp, Time(std::chrono::seconds(5)));
  EXPECT_EQ(all[before + 1].arrival, Time{}) << "is set by the host";
  EXPECT_EQ(last.sequence, before + 2);
  EXPECT_TRUE(reader.wait_for_event("connected: first datagram from 127.0.0.1:"));
}

TEST_F(JsonUdp, SkipsBadLinesWithPeerAndNumber) {
  LiveReader reader(make(yaml()));
  send_first(reader, wheels(0));
  const std::size_t before = reader.measurements().size();
  send("{\"sensor\":\n" + wheels(1));
  ASSERT_TRUE(reader.wait_for(before + 1));
  EXPECT_TRUE(reader.wait_for_event("1 bad line so far; udp 127.0.0.1:"));
  reader.stop();
  ASSERT_THAT(reader.source().bad_records(), SizeIs(1));
  EXPECT_THAT(reader.source().bad_records().front().place,
              StartsWith(fmt::format("udp 127.0.0.1:{}, datagram ", socket_.local_endpoint().port())));
  EXPECT_THAT(reader.source().bad_records().front().reason, StartsWith("no JSON at byte"));
}

TEST_F(JsonUdp, SurvivesRubbishAndReportsItSparingly) {
  LiveReader reader(make(yaml()));
  send_first(reader, wheels(0));
  std::mt19937 random(3);
  for (int i = 0; i < 3000; ++i) {
    std::string rubbish(1 + random() % 1000, ' ');
    for (char& c : rubbish) c = static_cast<char>(random() % 256);
    send(rubbish);
    if (i % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const std::size_t before = reader.measurements().size();
  ASSERT_TRUE(eventually([&] {
    send(wheels(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return reader.measurements().size() > before;
  }));
  reader.stop();
  EXPECT_LE(reader.source().take_events().size(), 15U);
  EXPECT_LE(reader.source().bad_records().size(), 1000U);
}

TEST_F(JsonUdp, APortOfAnotherProgramIsAnError) {
  udp::socket other(context_, udp::endpoint(loopback(), 0));
  LiveReader reader(make(fmt::format("from: udp\nport: {}", other.local_endpoint().port())));
  ASSERT_TRUE(reader.wait_for_end());
  EXPECT_THAT(reader.failure(), AllOf(StartsWith("udp 127.0.0.1:"), HasSubstr("Address already in use")));
}

TEST_F(JsonUdp, AnAddressThatIsNotThereYetIsWaitedFor) {
  EXPECT_TRUE(ends_soon([&] {
    LiveReader reader(make(fmt::format("from: udp\nport: {}\naddress: 192.0.2.7", endpoint_.port())));
    EXPECT_TRUE(reader.wait_for_event("cannot be opened: Cannot assign requested address; it is tried again"));
    const auto duration = reader.stop();
    EXPECT_EQ(reader.failure(), "");
    return duration;
  }));
}

TEST_F(JsonUdp, StopsWithinATenthOfASecond) {
  for (const bool has_sent : {false, true}) {
    EXPECT_TRUE(ends_soon([&] {
      LiveReader reader(make(yaml()));
      if (has_sent) send_first(reader, wheels(0));
      const auto duration = reader.stop();
      EXPECT_FALSE(reader.source().next().has_value());
      return duration;
    }));
  }
  const auto never_read = make(yaml());
  never_read->stop();
  EXPECT_FALSE(never_read->next().has_value());
}

class JsonTcp : public JsonLive {
 protected:
  std::string yaml(const std::string& more = "") const {
    return fmt::format("from: tcp\nport: {}\n{}", endpoint_.port(), more);
  }
  tcp::endpoint endpoint_{loopback(), free_port(SOCK_STREAM)};
};

TEST_F(JsonTcp, ReadsSeveralClientsAtATime) {
  LiveReader reader(make(yaml()));
  tcp::socket one(context_);
  tcp::socket two(context_);
  connect(one, endpoint_);
  connect(two, endpoint_);
  const std::string line = wheels(1);
  send(one, line.substr(0, 10));
  send(two, wheels(2));
  ASSERT_TRUE(reader.wait_for(1));
  EXPECT_EQ(reader.measurements()[0].as<WheelSpeeds>().left_mps, 2.0);
  send(one, line.substr(10));
  ASSERT_TRUE(reader.wait_for(2));
  EXPECT_EQ(reader.measurements()[1].as<WheelSpeeds>().left_mps, 1.0);
}

TEST_F(JsonTcp, AClientThatGoesAndComesIsReported) {
  LiveReader reader(make(yaml()));
  {
    tcp::socket client(context_);
    connect(client, endpoint_);
    send(client, wheels(1) + wheels(2) + R"({"sensor":"wheels","left_mps":3,"right_mps":3})");
  }
  ASSERT_TRUE(reader.wait_for(3)) << "the last line needs no end";
  EXPECT_TRUE(reader.wait_for_event("connected: 127.0.0.1:"));
  EXPECT_TRUE(reader.wait_for_event("after 3 lines: it closed the connection"));
  tcp::socket client(context_);
  connect(client, endpoint_);
  send(client, wheels(4));
  ASSERT_TRUE(reader.wait_for(4));
  EXPECT_TRUE(reader.wait_for_event("restored: 127.0.0.1:"));
}

TEST_F(JsonTcp, ABadLineHasPeerAndNumber) {
  LiveReader reader(make(yaml("max_line_bytes: 200")));
  tcp::socket client(context_);
  connect(client, endpoint_);
  send(client, wheels(1) + "[]\n" + std::string(5000, 'x') + "\n" + wheels(2));
  ASSERT_TRUE(reader.wait_for(2));
  reader.stop();
  ASSERT_THAT(reader.source().bad_records(), SizeIs(2));
  const std::string peer =
      fmt::format("tcp 127.0.0.1:{} from 127.0.0.1:{}, line ", endpoint_.port(), client.local_endpoint().port());
  EXPECT_EQ(reader.source().bad_records()[0].place, peer + "2");
  EXPECT_EQ(reader.source().bad_records()[1].place, peer + "3");
  EXPECT_EQ(reader.source().bad_records()[1].reason, "the line is longer than 200 bytes");
}

TEST_F(JsonTcp, RefusesMoreClientsThanItIsMeantFor) {
  LiveReader reader(make(yaml("max_clients: 1")));
  tcp::socket one(context_);
  tcp::socket two(context_);
  connect(one, endpoint_);
  send(one, wheels(1));
  ASSERT_TRUE(reader.wait_for(1));
  connect(two, endpoint_);
  EXPECT_TRUE(reader.wait_for_event("is refused: there are 1 clients"));
  send(one, wheels(2));
  EXPECT_TRUE(reader.wait_for(2));
  char byte = 0;
  boost::system::error_code error;
  two.read_some(asio::buffer(&byte, 1), error);
  EXPECT_TRUE(error) << "the second one is disconnected";
}

TEST_F(JsonTcp, StopsWithinATenthOfASecondWhileClientsSend) {
  EXPECT_TRUE(ends_soon([&] {
    LiveReader reader(make(yaml()));
    tcp::socket client(context_);
    connect(client, endpoint_);
    std::atomic<bool> sending = true;
    std::thread sender([&] {
      const std::string rubbish = std::string(100, '[') + "\n";
      boost::system::error_code error;
      while (sending && !error) asio::write(client, asio::buffer(rubbish), error);
    });
    EXPECT_TRUE(reader.wait_for_event("bad lines so far"));
    const auto duration = reader.stop();
    sending = false;
    boost::system::error_code closed_by_the_source;
    client.shutdown(tcp::socket::shutdown_both, closed_by_the_source);
    sender.join();
    return duration;
  }));
}

using JsonUnix = JsonLive;

TEST_F(JsonUnix, ListensForItsOwnerOnlyAndRemovesItsFile) {
  const std::string path = folder_ / "robot.sock";
  {
    LiveReader reader(make("from: unix\npath: robot.sock"));
    asio::local::stream_protocol::socket client(context_);
    connect(client, asio::local::stream_protocol::endpoint(path));
    struct stat status {};
    ASSERT_EQ(::stat(path.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0600U);
    asio::write(client, asio::buffer(wheels(1)));
    EXPECT_TRUE(reader.wait_for(1));

    LiveReader second(make("from: unix\npath: robot.sock"));
    ASSERT_TRUE(second.wait_for_end());
    EXPECT_THAT(second.failure(), HasSubstr("another program listens at it"));
  }
  EXPECT_FALSE(folder_.has("robot.sock"));
}

TEST_F(JsonUnix, ReplacesASocketThatNobodyListensAtButNoOtherFile) {
  const std::string path = folder_ / "robot.sock";
  { asio::local::stream_protocol::acceptor left_behind(context_, asio::local::stream_protocol::endpoint(path)); }
  ASSERT_TRUE(folder_.has("robot.sock"));
  {
    LiveReader reader(make("from: unix\npath: robot.sock"));
    asio::local::stream_protocol::socket client(context_);
    connect(client, asio::local::stream_protocol::endpoint(path));
  }
  std::ofstream(path) << "precious";
  LiveReader reader(make("from: unix\npath: robot.sock"));
  ASSERT_TRUE(reader.wait_for_end());
  EXPECT_THAT(reader.failure(), HasSubstr("the file is not a socket"));
  EXPECT_EQ(folder_.read("robot.sock"), "precious");
}

TEST(JsonInput, EndsWithThePipeOrWhenItIsStopped) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  live::EventList events;
  json::InputFeed feed(ends[0], 100, events);
  ASSERT_EQ(::write(ends[1], "one\ntwo", 7), 7);
  json::FedLine line;
  ASSERT_TRUE(feed.next(line));
  EXPECT_EQ(line.line.text, "one");
  EXPECT_EQ(line.place(), "stdin:1");
  std::thread closer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ::close(ends[1]);
  });
  ASSERT_TRUE(feed.next(line));
  EXPECT_EQ(line.line.text, "two");
  EXPECT_FALSE(feed.next(line));
  closer.join();
  EXPECT_THAT(events.take(), ElementsAre("stdin: it has ended"));
  ::close(ends[0]);

  EXPECT_TRUE(ends_soon([&] {
    EXPECT_EQ(::pipe(ends), 0);
    json::InputFeed waiting(ends[0], 100, events);
    std::atomic<std::chrono::steady_clock::time_point> stopped_at{};
    std::thread stopper([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      stopped_at = std::chrono::steady_clock::now();
      waiting.stop();
    });
    EXPECT_FALSE(waiting.next(line));
    const auto end = std::chrono::steady_clock::now();
    stopper.join();
    EXPECT_FALSE(waiting.next(line));
    ::close(ends[0]);
    ::close(ends[1]);
    return end - stopped_at.load();
  }));
}

}  // namespace
}  // namespace waymark::json_test
