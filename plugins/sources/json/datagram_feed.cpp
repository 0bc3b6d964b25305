// SPDX-License-Identifier: Apache-2.0
#include "datagram_feed.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::json {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

constexpr std::size_t kMostBytes = 65536;        // no datagram is longer
constexpr int kKernelBufferBytes = 1024 * 1024;  // the kernel may grant less

}  // namespace

DatagramFeed::DatagramFeed(live::NetworkPlace place, live::EventList& events)
    : LiveFeed(events), place_(std::move(place)), socket_(context_), timer_(context_), buffer_(kMostBytes) {}

void DatagramFeed::open() {
  try {
    const udp::endpoint endpoint(place_.address, place_.port);
    socket_.open(endpoint.protocol());
    boost::system::error_code ignored;
    socket_.set_option(asio::socket_base::receive_buffer_size(kKernelBufferBytes), ignored);
    socket_.bind(endpoint);
    socket_.non_blocking(true);
  } catch (const boost::system::system_error& failure) {
    const auto& code = failure.code();
    const std::string reason = "cannot be opened: " + code.message();
    if (code == asio::error::address_in_use || code == asio::error::access_denied)
      throw DataError(fmt::format("{}: {}", name(), reason));
    return reopen_later(reason);
  }
  const int yes = 1;
  ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes);
  lost_ = 0;
  back_off_.reset();
  if (std::exchange(is_lost_, false)) events_.add(name() + ": restored");
  wait();
}

void DatagramFeed::reopen_later(const std::string& reason) {
  boost::system::error_code ignored;
  socket_.close(ignored);
  if (!std::exchange(is_lost_, true)) events_.add(fmt::format("{}: lost: {}; it is tried again", name(), reason));
  timer_.expires_after(back_off_.next());
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) open();
  });
}

void DatagramFeed::wait() {
  socket_.async_wait(udp::socket::wait_read, [this](const boost::system::error_code& error) {
    if (error == asio::error::operation_aborted) return;
    if (error) return reopen_later(error.message());
    receive();
  });
}

/// Asio reads no control messages, and the kernel's count of lost datagrams is one.
void DatagramFeed::receive() {
  udp::endpoint sender;
  iovec place{buffer_.data(), buffer_.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(std::uint32_t))> control{};
  msghdr message{};
  message.msg_name = sender.data();
  message.msg_namelen = static_cast<socklen_t>(sender.capacity());
  message.msg_iov = &place;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t count = ::recvmsg(socket_.native_handle(), &message, MSG_DONTWAIT);
  if (count < 0) {
    if (errno == EAGAIN || errno == EINTR || errno == ECONNREFUSED) return wait();
    return reopen_later(std::strerror(errno));
  }
  sender.resize(message.msg_namelen);
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t lost = 0;
    std::memcpy(&lost, CMSG_DATA(part), sizeof lost);
    report_lost(lost);
  }
  take({buffer_.data(), static_cast<std::size_t>(count)}, sender);
  wait();
}

/// At 1, 10, 100, … lost datagrams.
void DatagramFeed::report_lost(std::uint32_t count) {
  constexpr std::uint64_t kStep = 10;
  lost_ = count;
  if (lost_ < next_report_) return;
  events_.add(fmt::format("{}: {} datagrams were lost, since they came faster than they were read", name(), lost_));
  while (next_report_ <= lost_) next_report_ *= kStep;
}

void DatagramFeed::take(std::string_view datagram, const udp::endpoint& sender) {
  const std::string peer = live::NetworkPlace{sender.address(), sender.port()}.text();
  if (!std::exchange(has_received_, true))
    events_.add(fmt::format("{}: connected: first datagram from {}", name(), peer));
  const auto origin = std::make_shared<const std::string>(fmt::format("udp {}, datagram ", peer));
  ++datagrams_;
  while (!datagram.empty()) {
    const std::size_t end = std::min(datagram.find('\n'), datagram.size());
    add({std::string(datagram.substr(0, end)), datagrams_, false}, origin);
    datagram.remove_prefix(std::min(end + 1, datagram.size()));
  }
}

}  // namespace waymark::json
