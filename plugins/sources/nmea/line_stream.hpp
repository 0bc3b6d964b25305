// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "line_input.hpp"
#include "waymark/base/time.hpp"

namespace waymark::nmea {

/// The lines of a file, a FIFO or the standard input. Lines end with LF, CR LF or CR.
class LineStream final : public LineInput {
 public:
  /// `file`: "-" is the standard input. It is opened by the first `next`, as opening a FIFO waits for its writer.
  /// `patience`: how long more lines are waited for at the end of a regular file that grows.
  LineStream(std::filesystem::path file, Duration patience);
  ~LineStream() override;
  LineStream(const LineStream&) = delete;
  LineStream& operator=(const LineStream&) = delete;

  /// The next line, without its end; false at the end, and where a signal ends the wait for more: the host handles only
  /// those that end a run. Throws DataError if the file cannot be read.
  bool next(std::string& line);

  Got read(std::string& line) override { return next(line) ? Got::line : Got::end; }
  std::string place() const override;
  double progress() const override;

 private:
  bool open();
  bool refill();

  std::filesystem::path file_;
  Duration patience_;
  bool is_file_;
  int descriptor_ = -1;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t consumed_ = 0;
  std::uint64_t size_ = 0;
  std::uint64_t line_ = 0;
  bool after_cr_ = false;
};

}  // namespace waymark::nmea
