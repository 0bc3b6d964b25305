// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <deque>

#include "line_feed.hpp"
#include "plugins/shared/live/event_list.hpp"

namespace waymark::json {

/// What all feeds from the network have in common: a queue of lines that is filled while `next` waits, so there is
/// never more in it than arrived in one piece.
class LiveFeed : public LineFeed {
 public:
  explicit LiveFeed(live::EventList& events) : events_(events) {}

  bool next(FedLine& line) final;
  void stop() final;

 protected:
  /// Called by the first `next`, in its thread. Throws Error.
  virtual void open() = 0;
  void add(live::Line line, std::shared_ptr<const std::string> origin) {
    lines_.push_back({std::move(line), std::move(origin)});
  }

  boost::asio::io_context context_;
  live::EventList& events_;

 private:
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{context_.get_executor()};
  std::deque<FedLine> lines_;
  std::atomic<bool> stopped_ = false;
  bool opened_ = false;
};

}  // namespace waymark::json
