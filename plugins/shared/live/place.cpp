// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/place.hpp"

#include <fmt/format.h>

#include <boost/asio/ip/tcp.hpp>
#include <cstring>

namespace waymark::live {

std::string NetworkPlace::text() const {
  const std::string number = address.to_string();
  return fmt::format("{}:{}", address.is_v6() ? "[" + number + "]" : number, port);
}

NetworkPlace read_network_place(const Config& config, std::string_view meaning_of_address,
                                std::optional<std::uint16_t> default_port) {
  NetworkPlace place;
  const std::string address = config.text({"address", meaning_of_address}, "127.0.0.1");
  boost::system::error_code error;
  place.address = boost::asio::ip::make_address(address, error);
  if (error) config.fail("address", fmt::format("\"{}\" is not a numeric address such as 127.0.0.1", address));
  constexpr std::int64_t kMostPort = 65535;
  const Config::Key key("port", "number of the UDP or TCP port");
  const std::int64_t port = default_port ? config.integer(key, *default_port) : config.integer(key);
  if (port < 1 || port > kMostPort) config.fail("port", fmt::format("{} is not in [1, {}]", port, kMostPort));
  place.port = static_cast<std::uint16_t>(port);
  return place;
}

std::string text_of(const ServerPlace& place) {
  if (const auto* network = std::get_if<NetworkPlace>(&place)) return "tcp " + network->text();
  return "unix " + std::get<std::filesystem::path>(place).string();
}

std::string text_of(const boost::asio::generic::stream_protocol::endpoint& peer) {
  const int family = peer.protocol().family();
  if (family != AF_INET && family != AF_INET6) return "client";
  boost::asio::ip::tcp::endpoint address;
  if (peer.size() > address.capacity()) return "client";
  std::memcpy(address.data(), peer.data(), peer.size());
  address.resize(peer.size());
  return NetworkPlace{address.address(), address.port()}.text();
}

}  // namespace waymark::live
