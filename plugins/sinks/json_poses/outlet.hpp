// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "plugins/shared/live/event_list.hpp"
#include "plugins/shared/live/place.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::json_poses {

/// Takes lines, and never waits for whoever reads them.
class Outlet {
 public:
  virtual ~Outlet() = default;
  /// `line` ends with a line break.
  virtual void send(std::string_view line) = 0;
  /// There will be no more.
  virtual void finish() = 0;
};

/// Lines of a file.
class FileOutlet final : public Outlet {
 public:
  /// Throws Error.
  explicit FileOutlet(const std::filesystem::path& file) : file_(file) {}
  void send(std::string_view line) override { file_.write(line); }
  void finish() override { file_.commit(); }

 private:
  OutputFile file_;
};

/// A datagram for each line.
class DatagramOutlet final : public Outlet {
 public:
  /// Throws Error if there are no sockets.
  DatagramOutlet(live::NetworkPlace to, live::EventList& events);
  void send(std::string_view line) override;
  void finish() override;

 private:
  live::EventList& events_;
  live::NetworkPlace to_;
  boost::asio::io_context context_;
  boost::asio::ip::udp::socket socket_;
  std::uint64_t left_out_ = 0;
  bool is_lost_ = false;
};

}  // namespace waymark::json_poses
