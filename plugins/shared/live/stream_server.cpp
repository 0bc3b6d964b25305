// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/stream_server.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cerrno>
#include <cstring>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::live {
namespace {

namespace asio = boost::asio;
using asio::generic::stream_protocol;

/// Faults of the network that may pass: an address that is not there yet, an interface that is down.
bool may_pass(const boost::system::error_code& error) {
  return error == asio::error::network_down || error == asio::error::network_unreachable ||
         error == boost::system::errc::address_not_available;
}

/// Removes the file of a socket that nobody listens at any more. Throws Error if it is something else.
void remove_stale(const std::filesystem::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return;
  if (!S_ISSOCK(status.st_mode)) throw Error(fmt::format("unix {}: the file is not a socket", path.string()));
  asio::io_context context;
  asio::local::stream_protocol::socket probe(context);
  boost::system::error_code error;
  probe.connect(asio::local::stream_protocol::endpoint(path.string()), error);
  if (!error) throw Error(fmt::format("unix {}: another program listens at it", path.string()));
  if (::unlink(path.c_str()) != 0)
    throw Error(fmt::format("unix {}: cannot be removed: {}", path.string(), std::strerror(errno)));
}

}  // namespace

StreamServer::StreamServer(asio::io_context& context, ServerPlace place, EventList& events, Accept accept)
    : place_(std::move(place)), events_(events), accept_(std::move(accept)), acceptor_(context), timer_(context) {}

StreamServer::~StreamServer() {
  if (has_file_) ::unlink(std::get<std::filesystem::path>(place_).c_str());
}

void StreamServer::listen_at(const NetworkPlace& network) {
  const asio::ip::tcp::endpoint endpoint(network.address, network.port);
  acceptor_.open(stream_protocol(endpoint.protocol()));
  acceptor_.set_option(asio::socket_base::reuse_address(true));
  acceptor_.bind(endpoint);
}

void StreamServer::listen_at(const std::filesystem::path& path) {
  constexpr std::size_t kLongest = sizeof(sockaddr_un::sun_path) - 1;
  if (path.native().size() > kLongest)
    throw Error(fmt::format("unix {}: the path is longer than {} bytes", path.string(), kLongest));
  remove_stale(path);
  const asio::local::stream_protocol::endpoint endpoint(path.string());
  acceptor_.open(stream_protocol(endpoint.protocol()));
  acceptor_.bind(endpoint);
  has_file_ = true;
  // Nobody can connect before `listen`, so there is no moment at which others could.
  if (::chmod(path.c_str(), S_IRUSR | S_IWUSR) != 0)
    throw Error(fmt::format("unix {}: mode 0600 cannot be set: {}", path.string(), std::strerror(errno)));
}

void StreamServer::listen() {
  std::visit([this](const auto& place) { listen_at(place); }, place_);
  acceptor_.listen();
}

void StreamServer::open() {
  try {
    listen();
  } catch (const boost::system::system_error& failure) {
    acceptor_.close();
    const std::string text = fmt::format("{}: cannot be listened at: {}", text_of(place_), failure.code().message());
    if (!may_pass(failure.code())) throw Error(text);
    if (!std::exchange(is_lost_, true)) events_.add(text + "; it is tried again");
    return open_later();
  }
  back_off_.reset();
  if (std::exchange(is_lost_, false)) events_.add(text_of(place_) + ": listens now");
  accept_next();
}

void StreamServer::open_later() {
  timer_.expires_after(back_off_.next());
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) open();
  });
}

void StreamServer::accept_next() {
  acceptor_.async_accept([this](const boost::system::error_code& error, StreamSocket client) {
    if (error == asio::error::operation_aborted) return;
    if (error) {
      // Too many open files, or the client is gone already. A pause, so that the fault is not repeated at once.
      timer_.expires_after(back_off_.next());
      timer_.async_wait([this](const boost::system::error_code& aborted) {
        if (!aborted) accept_next();
      });
      return;
    }
    back_off_.reset();
    boost::system::error_code gone;
    const stream_protocol::endpoint peer = client.remote_endpoint(gone);
    if (!gone) accept_(std::move(client), text_of(peer));
    accept_next();
  });
}

}  // namespace waymark::live
