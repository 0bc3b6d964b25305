// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/innovations.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

std::vector<InnovationScore> read_text(const std::string& text) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "diagnostics.json") << text;
  return read_innovations(folder / "diagnostics.json");
}

TEST(Innovations, HaveBoundsThatNarrowWithTheirNumber) {
  const auto scores = read_text(R"({"sensors": [{"name": "gps", "mean_nis": 2.5, "nis_count": 100, "nis_dof": 200},)"
                                R"( {"name": "lidar", "mean_nis": null, "nis_count": 0, "nis_dof": 0},)"
                                R"( {"name": "wheels", "mean_nis": 2.9, "nis_count": 10000, "nis_dof": 30000}]})");
  ASSERT_EQ(scores.size(), 2u) << "a sensor without updates has no NIS";
  EXPECT_EQ(scores[0].sensor, "gps");
  EXPECT_EQ(scores[0].updates, 100u);
  EXPECT_DOUBLE_EQ(scores[0].mean, 2.5);
  EXPECT_DOUBLE_EQ(scores[0].expected, 2.0);
  // χ² with 200 degrees of freedom: 162.73 and 241.06 (tables).
  EXPECT_NEAR(scores[0].low, 1.6273, 1e-3);
  EXPECT_NEAR(scores[0].high, 2.4106, 1e-3);
  EXPECT_NEAR(scores[1].low, 3.0 - 1.96 * 0.0245, 1e-3);
  EXPECT_NEAR(scores[1].high, 3.0 + 1.96 * 0.0245, 1e-3);
}

TEST(Innovations, AnotherFileIsRefusedByName) {
  for (const char* text : {"no JSON", "{}", R"({"sensors": [{"name": "gps"}]})"}) {
    try {
      read_text(text);
      FAIL() << text;
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("diagnostics.json"));
    }
  }
  EXPECT_THROW(read_innovations("/nowhere/diagnostics.json"), DataError);
}

}  // namespace
}  // namespace waymark::evaluation
