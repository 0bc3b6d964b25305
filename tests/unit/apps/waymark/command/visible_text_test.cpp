// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/visible_text.hpp"

#include <gtest/gtest.h>

namespace waymark::command {
namespace {

TEST(VisibleText, ShowsControlCharacters) {
  EXPECT_EQ(visible_text("a.csv:1: no column \"\x1b[31mt\x1b]0;x\a\""),
            "a.csv:1: no column \"\\x1b[31mt\\x1b]0;x\\x07\"");
  EXPECT_EQ(visible_text(std::string_view("a\0b\x7f\b\v", 6)), "a\\x00b\\x7f\\x08\\x0b");
  EXPECT_EQ(visible_text("\xc2\x9b"
                         "2J"),
            "\\x9b2J");
  EXPECT_EQ(visible_text("done\rwaymark: fine"), "done\\x0dwaymark: fine");
}

TEST(VisibleText, KeepsTheRest) {
  for (const char* text : {"", "one\n\ttwo\n", "\r[==  ] 50 %", "… and 3 more: 5 µm, Ä, 点", "\xc2\xa0", "\xc2"})
    EXPECT_EQ(visible_text(text), text);
}

TEST(VisibleLine, HasNoLineWithin) {
  EXPECT_EQ(visible_line("waymark: error: \"a\nwaymark: b\"\n"), "waymark: error: \"a\\nwaymark: b\"\n");
  EXPECT_EQ(visible_line("\r[==  ]"), "\r[==  ]");
  EXPECT_EQ(visible_line("\n"), "\n");
}

}  // namespace
}  // namespace waymark::command
