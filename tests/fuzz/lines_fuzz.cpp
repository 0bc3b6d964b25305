// SPDX-License-Identifier: Apache-2.0
// Lines of a serial port or a socket: however the bytes arrive, the lines are the same. Sentences of NMEA among them.
#include <deque>
#include <string>

#include "plugins/shared/live/line_splitter.hpp"
#include "plugins/sources/nmea/sentence.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::lines_harness {
namespace {

constexpr std::size_t kLongest = 100;

std::deque<live::Line> split(std::string_view bytes, std::size_t piece, live::LineEnd end) {
  live::LineSplitter splitter(kLongest, end);
  std::deque<live::Line> lines;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(piece, bytes.size())))
    splitter.add(bytes.substr(0, piece), lines);
  splitter.finish(lines);
  return lines;
}

void run(std::string_view input) {
  const Choice choice = choose(input, 64);
  const auto end = choice.which % 2 == 0 ? live::LineEnd::lf : live::LineEnd::lf_or_cr;
  const std::deque<live::Line> whole = split(choice.rest, std::string_view::npos, end);
  const std::deque<live::Line> pieces = split(choice.rest, 1 + choice.which / 2, end);
  if (whole.size() != pieces.size()) violation("the number of lines depends on how the bytes arrive");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole[i].text != pieces[i].text || whole[i].is_too_long != pieces[i].is_too_long || whole[i].number != i + 1 ||
        pieces[i].number != i + 1)
      violation("a line depends on how the bytes arrive");
    if (whole[i].text.size() > kLongest) violation("a line is longer than the longest");
    try {
      (void)nmea::read_sentence(whole[i].text, false);
    } catch (const nmea::Unusable&) {
      // the sentence is refused
    }
  }
}

const Harness kHarness("lines", run);

}  // namespace
}  // namespace waymark::fuzz::lines_harness
