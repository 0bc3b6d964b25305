// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/file_stems.hpp"

#include <gtest/gtest.h>

namespace waymark {
namespace {

TEST(FileStems, KeepsLettersDigitsUnderscoreAndDash) {
  FileStems stems({});
  EXPECT_EQ(stems.of("Laser-2_left"), "Laser-2_left");
  EXPECT_EQ(stems.of("../a b"), "___a_b");
}

TEST(FileStems, NumbersANameThatWasGivenBefore) {
  FileStems stems({});
  EXPECT_EQ(stems.of("a b"), "a_b");
  EXPECT_EQ(stems.of("a_b"), "a_b_2");
  EXPECT_EQ(stems.of("a.b"), "a_b_3");
}

TEST(FileStems, OfResultsLeavesTheEffectiveConfigurationAndTheManifestTheirNames) {
  FileStems stems = FileStems::of_results();
  EXPECT_EQ(stems.of("config"), "config_2");
  EXPECT_EQ(stems.of("maps"), "maps_2");
  EXPECT_EQ(stems.of("map"), "map");
}

}  // namespace
}  // namespace waymark
