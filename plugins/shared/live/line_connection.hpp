// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "plugins/shared/live/back_off.hpp"
#include "plugins/shared/live/event_list.hpp"
#include "plugins/shared/live/line_splitter.hpp"

namespace waymark::live {

/// Lines of one peer (a server, a serial port), to which the connection is restored whenever it is lost. Derived
/// classes connect and read.
class LineConnection {
 public:
  /// What ended the wait for a line.
  enum class Got { line, pause, lost, end };

  /// `name`: of the peer, for events. Ends of lines are LF, CR LF or CR.
  LineConnection(std::string name, std::size_t longest_line, EventList& events);
  virtual ~LineConnection() = default;
  LineConnection(const LineConnection&) = delete;
  LineConnection& operator=(const LineConnection&) = delete;

  /// Waits for the next line: `line` was set, nothing came for `patience` (zero: waits for ever), the connection was
  /// lost, or `stop` was called. By one thread. Lines are counted from the connection on.
  Got next(Line& line, std::chrono::milliseconds patience);
  /// By any thread.
  void stop();

 protected:
  using ReadHandler = std::function<void(const boost::system::error_code& error, std::size_t count)>;

  /// Begins to connect; `begin` or `lose` follows. Throws Error if it never can.
  virtual void connect() = 0;
  virtual void read_some(boost::asio::mutable_buffer into, ReadHandler done) = 0;
  virtual void close() = 0;

  /// The connection is there.
  void begin();
  /// The connection is lost, or there is none. One event, however often it is tried again.
  void lose(const std::string& reason);
  boost::asio::io_context& context() { return context_; }

 private:
  void read();

  std::string name_;
  std::size_t longest_line_;
  EventList& events_;
  boost::asio::io_context context_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  boost::asio::steady_timer retry_;
  boost::asio::steady_timer pause_;
  BackOff back_off_;
  std::vector<char> buffer_;
  LineSplitter splitter_;
  std::deque<Line> lines_;
  std::atomic<bool> stopped_ = false;
  std::uint64_t wait_ = 0;  // counts the calls of `next`
  bool is_over_ = false;    // its patience
  bool opened_ = false;
  bool was_connected_ = false;
  bool is_connected_ = false;
  bool is_reported_ = false;
  bool has_lost_ = false;
};

}  // namespace waymark::live
