// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/ip/address.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "waymark/config/config.hpp"

namespace waymark::live {

/// An address and port of the network.
struct NetworkPlace {
  boost::asio::ip::address address;
  std::uint16_t port = 0;

  std::string text() const;  ///< "127.0.0.1:5005"
};

/// Reads `address` and `port`. The address is a number, by default that of this machine only; the port is required
/// unless there is a `default_port`. Throws ConfigError.
NetworkPlace read_network_place(const Config& config, std::string_view meaning_of_address,
                                std::optional<std::uint16_t> default_port = {});

/// Where a server listens: a TCP port, or the path of a Unix socket.
using ServerPlace = std::variant<NetworkPlace, std::filesystem::path>;

/// "tcp 127.0.0.1:5005" or "unix /run/robot.sock".
std::string text_of(const ServerPlace& place);

/// The address of a peer, "127.0.0.1:40122"; of a Unix socket "client".
std::string text_of(const boost::asio::generic::stream_protocol::endpoint& peer);

}  // namespace waymark::live
