// SPDX-License-Identifier: Apache-2.0
#include "server_feed.hpp"

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <utility>

namespace waymark::json {
namespace {

namespace asio = boost::asio;

constexpr std::size_t kBytesOfARead = 1 << 14;

}  // namespace

struct ServerFeed::Client {
  Client(live::StreamSocket s, const std::string& peer, const std::string& server, std::size_t longest_line)
      : socket(std::move(s)),
        name(peer),
        splitter(longest_line, live::LineEnd::lf),
        origin(std::make_shared<const std::string>(fmt::format("{} from {}, line ", server, peer))),
        buffer(kBytesOfARead) {}

  live::StreamSocket socket;
  std::string name;
  live::LineSplitter splitter;
  std::shared_ptr<const std::string> origin;
  std::vector<char> buffer;
  std::uint64_t lines = 0;
};

ServerFeed::ServerFeed(live::ServerPlace place, StreamLimits limits, live::EventList& events)
    : LiveFeed(events),
      name_(live::text_of(place)),
      limits_(limits),
      server_(context_, std::move(place), events,
              [this](live::StreamSocket socket, const std::string& peer) { welcome(std::move(socket), peer); }) {}

ServerFeed::~ServerFeed() = default;

void ServerFeed::welcome(live::StreamSocket socket, const std::string& peer) {
  if (clients_.size() >= limits_.clients) {
    if (!std::exchange(is_full_, true))
      events_.add(fmt::format("{}: {} is refused: there are {} clients", name_, peer, clients_.size()));
    return;  // the socket is closed
  }
  boost::system::error_code ignored;
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  const bool again = std::exchange(was_connected_, true) && clients_.empty();
  events_.add(fmt::format("{}: {}: {}", name_, again ? "restored" : "connected", peer));
  clients_.emplace_back(std::move(socket), peer, name_, limits_.line_bytes);
  read(std::prev(clients_.end()));
}

void ServerFeed::read(std::list<Client>::iterator client) {
  client->socket.async_read_some(
      asio::buffer(client->buffer), [this, client](const boost::system::error_code& error, std::size_t count) {
        std::deque<live::Line> lines;
        client->splitter.add({client->buffer.data(), count}, lines);
        if (error) client->splitter.finish(lines);
        client->lines += lines.size();
        for (live::Line& line : lines) add(std::move(line), client->origin);
        if (!error) return read(client);
        if (error != asio::error::operation_aborted)
          dismiss(client, error == asio::error::eof ? "it closed the connection" : error.message());
      });
}

void ServerFeed::dismiss(std::list<Client>::iterator client, const std::string& reason) {
  events_.add(fmt::format("{}: lost: {} after {} lines: {}", name_, client->name, client->lines, reason));
  clients_.erase(client);
  is_full_ = false;
}

}  // namespace waymark::json
