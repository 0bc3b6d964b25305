// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/serial_port.hpp>
#include <chrono>
#include <string>

#include "line_input.hpp"
#include "plugins/shared/live/line_connection.hpp"

namespace waymark::nmea {

/// The lines that a receiver sends to a serial port, which is opened again when the receiver was unplugged.
class SerialLines final : public LineInput {
 public:
  /// 8 bits, no parity, one stop bit, no handshake. A pause is `quiet` without a line.
  SerialLines(const std::string& device, unsigned baud, std::chrono::milliseconds quiet, live::EventList& events)
      : port_(device, baud, events), place_("serial " + device + ", line "), quiet_(quiet) {}

  Got read(std::string& line) override;
  std::string place() const override { return place_ + std::to_string(line_.number); }
  void stop() override { port_.stop(); }

 private:
  class Port final : public live::LineConnection {
   public:
    Port(const std::string& device, unsigned baud, live::EventList& events);

   private:
    void connect() override;
    void read_some(boost::asio::mutable_buffer into, ReadHandler done) override;
    void close() override;

    std::string device_;
    unsigned baud_;
    boost::asio::serial_port port_;
  };

  Port port_;
  std::string place_;
  std::chrono::milliseconds quiet_;
  live::Line line_;
  bool has_paused_ = true;
};

}  // namespace waymark::nmea
