// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace waymark::nmea {

/// Lines of a receiver: of a log, or as they come.
class LineInput {
 public:
  static constexpr std::size_t kLongest = 1000;  ///< what follows in a line is left out
  enum class Got { line, pause, end };

  virtual ~LineInput() = default;
  /// The next line, without its end. Of a receiver at work also a pause, when it has sent nothing for a while. Throws
  /// DataError if there is nothing to read from.
  virtual Got read(std::string& line) = 0;
  virtual std::string place() const = 0;  ///< "file:line" of the last line
  /// Share that was read, 0..1; negative if that is unknown.
  virtual double progress() const { return -1.0; }
  /// `read` returns the end, now and from now on. Called by any thread.
  virtual void stop() {}
};

}  // namespace waymark::nmea
