// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>

#include "plugins/shared/live/line_connection.hpp"
#include "plugins/shared/live/place.hpp"

namespace waymark::gpsd {

/// A connection to gpsd that comes back when gpsd does.
class Connection final : public live::LineConnection {
 public:
  /// `device`: the receiver that is wanted, as gpsd names it; empty: any.
  Connection(const live::NetworkPlace& place, const std::string& device, live::EventList& events);

 private:
  void connect() override;
  void read_some(boost::asio::mutable_buffer into, ReadHandler done) override;
  void close() override;
  void start(const boost::system::error_code& error);

  boost::asio::ip::tcp::endpoint endpoint_;
  std::string request_;
  boost::asio::ip::tcp::socket socket_;
};

}  // namespace waymark::gpsd
