// SPDX-License-Identifier: Apache-2.0
#include "connection.hpp"

#include <netinet/tcp.h>

#include <boost/asio/write.hpp>
#include <nlohmann/json.hpp>
#include <utility>

namespace waymark::gpsd {
namespace {

namespace asio = boost::asio;

constexpr std::size_t kLongestLine = 1 << 16;  // gpsd's own limit is smaller

std::string request_for(const std::string& device) {
  nlohmann::ordered_json watch{{"enable", true}, {"json", true}};
  if (!device.empty()) watch["device"] = device;
  return "?WATCH=" + watch.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + ";\n";
}

/// A peer that is gone without a word (its cable is pulled) is noticed after about 20 s.
void notice_silent_ends(asio::ip::tcp::socket& socket) {
  boost::system::error_code ignored;
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  for (const auto& [option, value] : {std::pair{TCP_KEEPIDLE, 10}, {TCP_KEEPINTVL, 5}, {TCP_KEEPCNT, 2}})
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, option, &value, sizeof value);
}

}  // namespace

Connection::Connection(const live::NetworkPlace& place, const std::string& device, live::EventList& events)
    : LineConnection("gpsd " + place.text(), kLongestLine, events),
      endpoint_(place.address, place.port),
      request_(request_for(device)),
      socket_(context()) {}

void Connection::connect() {
  socket_.async_connect(endpoint_, [this](const boost::system::error_code& error) { start(error); });
}

void Connection::start(const boost::system::error_code& error) {
  if (error == asio::error::operation_aborted) return;
  if (error) return lose(error.message());
  notice_silent_ends(socket_);
  boost::system::error_code failure;
  asio::write(socket_, asio::buffer(request_), failure);  // shorter than any buffer of the kernel
  if (failure) return lose(failure.message());
  begin();
}

void Connection::read_some(asio::mutable_buffer into, ReadHandler done) {
  socket_.async_read_some(asio::mutable_buffers_1(into), std::move(done));
}

void Connection::close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
}

}  // namespace waymark::gpsd
