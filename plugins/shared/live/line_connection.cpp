// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/line_connection.hpp"

#include <fmt/format.h>

#include <boost/asio/error.hpp>
#include <utility>

namespace waymark::live {
namespace {

namespace asio = boost::asio;

constexpr std::size_t kBufferBytes = 1 << 14;

}  // namespace

LineConnection::LineConnection(std::string name, std::size_t longest_line, EventList& events)
    : name_(std::move(name)),
      longest_line_(longest_line),
      events_(events),
      work_(context_.get_executor()),
      retry_(context_),
      pause_(context_),
      buffer_(kBufferBytes),
      splitter_(longest_line, LineEnd::lf_or_cr) {}

void LineConnection::stop() {
  stopped_ = true;
  context_.stop();
}

LineConnection::Got LineConnection::next(Line& line, std::chrono::milliseconds patience) {
  if (stopped_) return Got::end;
  if (!std::exchange(opened_, true)) connect();
  const std::uint64_t wait = ++wait_;
  is_over_ = false;
  if (patience.count() > 0 && lines_.empty()) {
    pause_.expires_after(patience);
    pause_.async_wait([this, wait](const boost::system::error_code& error) {
      if (!error && wait == wait_) is_over_ = true;  // not of an earlier call
    });
  }
  while (lines_.empty() && !is_over_ && !has_lost_ && !stopped_) context_.run_one();
  if (stopped_) return Got::end;
  if (!lines_.empty()) {
    line = std::move(lines_.front());
    lines_.pop_front();
    return Got::line;
  }
  return std::exchange(has_lost_, false) ? Got::lost : Got::pause;
}

void LineConnection::begin() {
  splitter_ = LineSplitter(longest_line_, LineEnd::lf_or_cr);
  back_off_.reset();
  is_connected_ = true;
  is_reported_ = false;
  events_.add(fmt::format("{}: {}", name_, std::exchange(was_connected_, true) ? "restored" : "connected"));
  read();
}

void LineConnection::read() {
  read_some(asio::buffer(buffer_), [this](const boost::system::error_code& error, std::size_t count) {
    splitter_.add({buffer_.data(), count}, lines_);
    if (!error) return read();
    if (error != asio::error::operation_aborted)
      lose(error == asio::error::eof ? "it closed the connection" : error.message());
  });
}

void LineConnection::lose(const std::string& reason) {
  close();
  if (!std::exchange(is_reported_, true))
    events_.add(fmt::format("{}: {}: {}; it is tried again", name_, is_connected_ ? "lost" : "not reached", reason));
  has_lost_ = has_lost_ || is_connected_;
  is_connected_ = false;
  retry_.expires_after(back_off_.next());
  retry_.async_wait([this](const boost::system::error_code& error) {
    if (!error) connect();
  });
}

}  // namespace waymark::live
