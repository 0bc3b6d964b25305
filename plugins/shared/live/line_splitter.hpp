// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

namespace waymark::live {

/// One line of a stream.
struct Line {
  std::string text;          ///< without its end
  std::uint64_t number = 0;  ///< from 1
  bool is_too_long = false;  ///< the text is cut
};

/// Which characters end a line. LF alone leaves a CR in the text.
enum class LineEnd { lf, lf_or_cr };

/// Splits a stream of bytes, in pieces as they arrive, into lines. Keeps at most `longest` bytes of an unfinished line.
class LineSplitter {
 public:
  LineSplitter(std::size_t longest, LineEnd end) : longest_(longest), end_(end) {}

  /// Appends the lines that `bytes` completes. With `lf_or_cr`, CR LF is one end.
  void add(std::string_view bytes, std::deque<Line>& lines);
  /// Appends what follows the last end of a line, if there is anything, at the end of the stream.
  void finish(std::deque<Line>& lines);

 private:
  void keep(std::string_view bytes);
  void complete(std::deque<Line>& lines);

  std::size_t longest_;
  LineEnd end_;
  std::string text_;
  std::uint64_t number_ = 0;
  bool is_too_long_ = false;
  bool after_cr_ = false;
};

}  // namespace waymark::live
