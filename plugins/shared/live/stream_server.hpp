// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <string>

#include "plugins/shared/live/back_off.hpp"
#include "plugins/shared/live/event_list.hpp"
#include "plugins/shared/live/place.hpp"

namespace waymark::live {

using StreamSocket = boost::asio::generic::stream_protocol::socket;

/// Listens at a TCP port or a Unix socket and hands over every client that connects. All of it runs in the thread that
/// runs the context.
class StreamServer {
 public:
  /// `peer` is the client's address.
  using Accept = std::function<void(StreamSocket client, const std::string& peer)>;

  StreamServer(boost::asio::io_context& context, ServerPlace place, EventList& events, Accept accept);
  /// Removes the file of its Unix socket.
  ~StreamServer();
  StreamServer(const StreamServer&) = delete;
  StreamServer& operator=(const StreamServer&) = delete;

  /// Begins to listen; a Unix socket is for its owner only (mode 0600). While the network is not there it tries again
  /// and again, and reports that. Throws Error if the place cannot be used: it belongs to another program, or to a file
  /// that is not a socket.
  void open();

 private:
  using Acceptor = boost::asio::basic_socket_acceptor<boost::asio::generic::stream_protocol>;

  void listen();
  void listen_at(const NetworkPlace& network);
  void listen_at(const std::filesystem::path& path);
  void accept_next();
  void open_later();

  ServerPlace place_;
  EventList& events_;
  Accept accept_;
  Acceptor acceptor_;
  boost::asio::steady_timer timer_;
  BackOff back_off_;
  bool is_lost_ = false;
  bool has_file_ = false;
};

}  // namespace waymark::live
