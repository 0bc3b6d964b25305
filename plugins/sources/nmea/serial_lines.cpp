// SPDX-License-Identifier: Apache-2.0
#include "serial_lines.hpp"

#include <fmt/format.h>

#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::nmea {

namespace asio = boost::asio;

SerialLines::Port::Port(const std::string& device, unsigned baud, live::EventList& events)
    : LineConnection("serial " + device, kLongest, events), device_(device), baud_(baud), port_(context()) {}

void SerialLines::Port::connect() {
  using Setting = asio::serial_port_base;
  boost::system::error_code error;
  port_.open(device_, error);
  if (error) return lose(error.message());
  port_.set_option(Setting::baud_rate(baud_), error);
  if (!error) port_.set_option(Setting::character_size(8), error);
  if (!error) port_.set_option(Setting::parity(Setting::parity::none), error);
  if (!error) port_.set_option(Setting::stop_bits(Setting::stop_bits::one), error);
  if (!error) port_.set_option(Setting::flow_control(Setting::flow_control::none), error);
  if (error) return lose(fmt::format("{} baud cannot be set: {}", baud_, error.message()));
  begin();
}

void SerialLines::Port::read_some(asio::mutable_buffer into, ReadHandler done) {
  port_.async_read_some(asio::mutable_buffers_1(into), std::move(done));
}

void SerialLines::Port::close() {
  boost::system::error_code ignored;
  port_.close(ignored);
}

LineInput::Got SerialLines::read(std::string& line) {
  using Event = live::LineConnection::Got;
  for (;;) {
    // One pause is enough until something comes.
    switch (port_.next(line_, has_paused_ ? std::chrono::milliseconds::zero() : quiet_)) {
      case Event::line:
        has_paused_ = false;
        line = line_.text;
        return Got::line;
      case Event::pause:
      case Event::lost:
        if (!std::exchange(has_paused_, true)) return Got::pause;
        break;
      case Event::end:
        return Got::end;
    }
  }
}

}  // namespace waymark::nmea
