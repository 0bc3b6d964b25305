// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "plugins/shared/live/line_splitter.hpp"

namespace waymark::json {

/// A line with where it comes from.
struct FedLine {
  live::Line line;
  std::shared_ptr<const std::string> origin;  ///< "udp 127.0.0.1:40122, datagram " or "log.jsonl:"; the number follows

  std::string place() const { return *origin + std::to_string(line.number); }
};

/// Lines, as they come.
class LineFeed {
 public:
  virtual ~LineFeed() = default;
  /// Waits for the next line; false at the end. Throws Error if there will be none.
  virtual bool next(FedLine& line) = 0;
  /// `next` returns false, now and from now on. Called by any thread.
  virtual void stop() = 0;
  /// Share that was read, 0..1; negative if unknown.
  virtual double progress() const { return -1.0; }
};

}  // namespace waymark::json
