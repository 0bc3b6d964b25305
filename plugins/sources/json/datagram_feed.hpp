// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "live_feed.hpp"
#include "plugins/shared/live/back_off.hpp"
#include "plugins/shared/live/place.hpp"

namespace waymark::json {

/// The lines of datagrams that arrive at a UDP port. The last line of a datagram needs no end.
class DatagramFeed final : public LiveFeed {
 public:
  DatagramFeed(live::NetworkPlace place, live::EventList& events);

 private:
  void open() override;
  void wait();
  void receive();
  void take(std::string_view datagram, const boost::asio::ip::udp::endpoint& sender);
  void report_lost(std::uint32_t count);
  void reopen_later(const std::string& reason);
  std::string name() const { return "udp " + place_.text(); }

  live::NetworkPlace place_;
  boost::asio::ip::udp::socket socket_;
  boost::asio::steady_timer timer_;
  live::BackOff back_off_;
  std::vector<char> buffer_;
  std::uint64_t datagrams_ = 0;
  std::uint32_t lost_ = 0;  // by the kernel, since the socket is open
  std::uint64_t next_report_ = 1;
  bool is_lost_ = false;
  bool has_received_ = false;
};

}  // namespace waymark::json
