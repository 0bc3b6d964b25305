// SPDX-License-Identifier: Apache-2.0
#include "server_outlet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <deque>
#include <utility>
#include <vector>

#include "plugins/shared/live/thread_without_signals.hpp"

namespace waymark::json_poses {
namespace {

namespace asio = boost::asio;

using SharedLine = std::shared_ptr<const std::string>;

}  // namespace

struct ServerOutlet::Client {
  Client(live::StreamSocket s, std::string peer) : socket(std::move(s)), name(std::move(peer)) {}

  live::StreamSocket socket;
  std::string name;
  std::deque<SharedLine> waiting;
  std::vector<SharedLine> sending;
  std::array<char, 256> received{};  // nothing is expected
  std::uint64_t lines = 0;
  std::uint64_t left_out = 0;
};

ServerOutlet::ServerOutlet(live::ServerPlace place, ServerLimits limits, live::EventList& events)
    : name_(live::text_of(place)),
      limits_(limits),
      events_(events),
      work_(context_.get_executor()),
      server_(context_, std::move(place), events,
              [this](live::StreamSocket socket, const std::string& peer) { welcome(std::move(socket), peer); }) {
  server_.open();
  thread_ = live::thread_without_signals([this] { run(); });
}

ServerOutlet::~ServerOutlet() { stop(); }

void ServerOutlet::run() {
  try {
    context_.run();
  } catch (const std::exception& error) {
    events_.add(fmt::format("{}: lost: {}", name_, error.what()));
  }
}

void ServerOutlet::stop() {
  context_.stop();
  if (thread_.joinable()) thread_.join();
}

void ServerOutlet::welcome(live::StreamSocket socket, const std::string& peer) {
  const std::lock_guard lock(mutex_);
  if (clients_.size() >= limits_.clients) {
    if (!std::exchange(is_full_, true))
      events_.add(fmt::format("{}: {} is refused: there are {} clients", name_, peer, clients_.size()));
    return;  // the socket is closed
  }
  boost::system::error_code ignored;
  if (peer != "client") socket.set_option(asio::ip::tcp::no_delay(true), ignored);
  const bool again = std::exchange(was_connected_, true) && clients_.empty();
  events_.add(fmt::format("{}: {}: {}", name_, again ? "restored" : "connected", peer));
  clients_.push_back(std::make_shared<Client>(std::move(socket), peer));
  watch(clients_.back());
}

/// Reads nothing but the end of the connection.
void ServerOutlet::watch(const std::shared_ptr<Client>& client) {
  client->socket.async_read_some(
      asio::buffer(client->received), [this, client](const boost::system::error_code& error, std::size_t) {
        if (!error) return watch(client);
        dismiss(client, error == asio::error::eof ? "it closed the connection" : error.message());
      });
}

void ServerOutlet::dismiss(const std::shared_ptr<Client>& client, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(clients_, client);
  if (found == clients_.end()) return;
  const std::uint64_t missing = client->left_out + client->waiting.size() + client->sending.size();
  events_.add(fmt::format("{}: lost: {} after {} lines; {} were left out: {}", name_, client->name, client->lines,
                          missing, reason));
  clients_.erase(found);
  boost::system::error_code ignored;
  client->socket.close(ignored);
  is_full_ = false;
  progress_.notify_all();
}

void ServerOutlet::send(std::string_view line) {
  const std::lock_guard lock(mutex_);
  if (clients_.empty()) return;
  const auto shared = std::make_shared<const std::string>(line);
  for (const auto& client : clients_) {
    if (client->waiting.size() >= limits_.lines) {
      client->waiting.pop_front();
      if (client->left_out++ == 0)
        events_.add(fmt::format("{}: {} reads too slowly: the oldest lines are left out", name_, client->name));
    }
    client->waiting.push_back(shared);
  }
  if (std::exchange(is_woken_, true)) return;
  asio::post(context_, [this] { write_all(); });
}

void ServerOutlet::write_all() {
  const std::lock_guard lock(mutex_);
  is_woken_ = false;
  for (const auto& client : clients_) write(client);
}

/// With the mutex locked.
void ServerOutlet::write(const std::shared_ptr<Client>& client) {
  if (!client->sending.empty() || client->waiting.empty()) return;
  constexpr std::size_t kMost = 16;
  const auto count = static_cast<std::ptrdiff_t>(std::min(kMost, client->waiting.size()));
  client->sending.assign(client->waiting.begin(), client->waiting.begin() + count);
  client->waiting.erase(client->waiting.begin(), client->waiting.begin() + count);
  std::vector<asio::const_buffer> buffers;
  buffers.reserve(client->sending.size());
  for (const SharedLine& line : client->sending) buffers.emplace_back(asio::buffer(*line));
  asio::async_write(client->socket, buffers, [this, client](const boost::system::error_code& error, std::size_t) {
    if (error) return dismiss(client, error.message());
    const std::lock_guard lock(mutex_);
    client->lines += client->sending.size();
    client->sending.clear();
    write(client);
    if (client->sending.empty()) progress_.notify_all();
  });
}

void ServerOutlet::finish() {
  constexpr auto kPatience = std::chrono::milliseconds(500);
  {
    std::unique_lock lock(mutex_);
    progress_.wait_for(lock, kPatience, [this] {
      return std::ranges::all_of(clients_, [](const auto& c) { return c->waiting.empty() && c->sending.empty(); });
    });
  }
  stop();
  std::uint64_t left_out = 0;
  for (const auto& client : clients_) left_out += client->left_out + client->waiting.size() + client->sending.size();
  if (left_out > 0) events_.add(fmt::format("{}: {} lines were left out for slow clients", name_, left_out));
  clients_.clear();
}

}  // namespace waymark::json_poses
