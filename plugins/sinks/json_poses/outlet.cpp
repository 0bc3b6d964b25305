// SPDX-License-Identifier: Apache-2.0
#include "outlet.hpp"

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::json_poses {

namespace asio = boost::asio;

DatagramOutlet::DatagramOutlet(live::NetworkPlace to, live::EventList& events)
    : events_(events), to_(std::move(to)), socket_(context_) {
  boost::system::error_code error;
  socket_.open(to_.address.is_v6() ? asio::ip::udp::v6() : asio::ip::udp::v4(), error);
  if (!error) socket_.non_blocking(true, error);
  if (error) throw Error(fmt::format("udp {}: cannot be opened: {}", to_.text(), error.message()));
}

void DatagramOutlet::send(std::string_view line) {
  boost::system::error_code error;
  socket_.send_to(asio::buffer(line), {to_.address, to_.port}, 0, error);
  if (error) {
    ++left_out_;
    if (!std::exchange(is_lost_, true)) events_.add(fmt::format("udp {}: lost: {}", to_.text(), error.message()));
  } else if (std::exchange(is_lost_, false)) {
    events_.add(fmt::format("udp {}: restored; {} lines were left out so far", to_.text(), left_out_));
  }
}

void DatagramOutlet::finish() {
  if (left_out_ > 0) events_.add(fmt::format("udp {}: {} lines were left out", to_.text(), left_out_));
}

}  // namespace waymark::json_poses
