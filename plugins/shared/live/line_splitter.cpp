// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/line_splitter.hpp"

#include <algorithm>
#include <utility>

namespace waymark::live {

void LineSplitter::keep(std::string_view bytes) {
  const std::size_t room = longest_ - std::min(longest_, text_.size());
  if (bytes.size() > room) is_too_long_ = true;
  text_.append(bytes.substr(0, room));
}

void LineSplitter::complete(std::deque<Line>& lines) {
  lines.push_back({std::exchange(text_, {}), ++number_, std::exchange(is_too_long_, false)});
}

void LineSplitter::add(std::string_view bytes, std::deque<Line>& lines) {
  const std::string_view ends = end_ == LineEnd::lf ? "\n" : "\r\n";
  while (!bytes.empty()) {
    if (std::exchange(after_cr_, false) && bytes.front() == '\n') {
      bytes.remove_prefix(1);  // the second half of CR LF
      continue;
    }
    const std::size_t end = bytes.find_first_of(ends);
    keep(bytes.substr(0, end));
    if (end == std::string_view::npos) return;
    after_cr_ = bytes[end] == '\r';
    bytes.remove_prefix(end + 1);
    complete(lines);
  }
}

void LineSplitter::finish(std::deque<Line>& lines) {
  if (!text_.empty()) complete(lines);
}

}  // namespace waymark::live
