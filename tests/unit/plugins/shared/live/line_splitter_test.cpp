// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/line_splitter.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace waymark::live {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> texts_of(const std::deque<Line>& lines) {
  std::vector<std::string> texts;
  for (const Line& line : lines)
    texts.push_back(std::to_string(line.number) + (line.is_too_long ? "!" : ":") + line.text);
  return texts;
}

/// Splits `text`, given in pieces of `step` bytes.
std::vector<std::string> split(const std::string& text, std::size_t step, LineEnd end, std::size_t longest = 100) {
  LineSplitter splitter(longest, end);
  std::deque<Line> lines;
  for (std::size_t i = 0; i < text.size(); i += step) splitter.add(std::string_view(text).substr(i, step), lines);
  splitter.finish(lines);
  return texts_of(lines);
}

TEST(LineSplitter, PiecesOfAnySizeGiveTheSameLines) {
  for (const std::size_t step : {1U, 2U, 3U, 5U, 100U}) {
    EXPECT_THAT(split("ab\n\ncd\r\ne", step, LineEnd::lf), ElementsAre("1:ab", "2:", "3:cd\r", "4:e")) << step;
    EXPECT_THAT(split("ab\r\ncd\re\n\nf", step, LineEnd::lf_or_cr), ElementsAre("1:ab", "2:cd", "3:e", "4:", "5:f"))
        << step;
  }
}

TEST(LineSplitter, CutsALineThatIsTooLongAndGoesOnWithTheNext) {
  for (const std::size_t step : {1U, 4U, 100U})
    EXPECT_THAT(split("12345678\n1234\n12345", step, LineEnd::lf, 4), ElementsAre("1!1234", "2:1234", "3!1234"))
        << step;
}

TEST(LineSplitter, KeepsNoMoreThanTheLongestLine) {
  LineSplitter splitter(10, LineEnd::lf);
  std::deque<Line> lines;
  const std::string block(1 << 16, 'x');
  for (int i = 0; i < 1000; ++i) splitter.add(block, lines);
  EXPECT_TRUE(lines.empty());
  splitter.add("\n", lines);
  EXPECT_THAT(texts_of(lines), ElementsAre("1!xxxxxxxxxx"));
}

}  // namespace
}  // namespace waymark::live
