// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/extraction_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

#include "temporary_folder.hpp"
#include "tests/unit/map_modules/feature_map/camera_bench.hpp"
#include "waymark/base/error.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::CameraScene;
using feature_map_test::kRedPaint;
using feature_map_test::LookedAt;
using ::testing::ElementsAre;

class ExtractionTableTest : public ::testing::Test {
 protected:
  Config config() const {
    Config config = Config::parse("{ extraction_table: " + file_.string() + " }");
    config.permit_outside();
    return config;
  }
  /// Fields of each row, the first row names them.
  std::vector<std::vector<std::string>> rows() const {
    std::ifstream in(file_);
    std::vector<std::vector<std::string>> all;
    for (std::string line; std::getline(in, line);) {
      all.emplace_back();
      std::istringstream fields(line + ",");
      for (std::string field; std::getline(fields, field, ',');) all.back().push_back(field);
    }
    return all;
  }
  void write(const LookedAt& seen, bool with_camera) const {
    ExtractionTable table(config(), "extraction_table");
    table.take({Time{from_seconds(12.5)}, seen.observation.view, seen.candidates, scene_.T_base_scanner,
                with_camera ? &seen.look : nullptr});
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "in/it/table.csv";
  // One pillar in the image and one beside it.
  CameraScene scene_{{{{5.0, 0.4}, 0.2, kRedPaint}, {{1.0, 4.0}, 0.2, kRedPaint}}};
};

TEST_F(ExtractionTableTest, EachCandidateIsARowWithWhatTheImageAdds) {
  const Measurement image = scene_.image(scene_.picture());
  const LookedAt seen(scene_, &image);
  ASSERT_EQ(seen.candidates.size(), 2U);
  write(seen, true);
  const auto table = rows();
  ASSERT_EQ(table.size(), 3U);
  EXPECT_THAT(table[0], ElementsAre("t_s", "first_beam", "last_beam", "verdict", "range_m", "bearing_rad", "radius_m",
                                    "x_m", "y_m", "in_image", "radius_sigma_m", "signature"));
  const auto& front = std::stod(table[1][7]) > 3.0 ? table[1] : table[2];
  const auto& aside = std::stod(table[1][7]) > 3.0 ? table[2] : table[1];
  for (const auto& row : {front, aside}) {
    ASSERT_EQ(row.size(), 12U);
    EXPECT_EQ(row[0], "12.500000000");
    EXPECT_EQ(row[3], "accepted");
    EXPECT_NEAR(std::stod(row[6]), 0.2, 0.03);
  }
  EXPECT_NEAR(std::stod(front[7]), 5.0, 0.05);
  EXPECT_NEAR(std::stod(front[8]), 0.4, 0.05);
  EXPECT_EQ(front[9], "1");
  EXPECT_GT(std::stod(front[10]), 0.0);
  double sum = 0.0;
  std::size_t bins = 0;
  std::istringstream signature(front[11]);
  for (std::string bin; std::getline(signature, bin, ';'); ++bins) sum += std::stod(bin);
  EXPECT_EQ(bins, 64U);
  EXPECT_NEAR(sum, 1.0, 0.01);
  EXPECT_EQ(aside[9], "0");
  EXPECT_EQ(aside[10], "");
  EXPECT_EQ(aside[11], "");
}

TEST_F(ExtractionTableTest, WithoutACameraTheImagesFieldsAreEmpty) {
  const LookedAt seen(scene_, nullptr);
  write(seen, false);
  const auto table = rows();
  ASSERT_EQ(table.size(), 3U);
  EXPECT_EQ(table[1][9], "0");
  EXPECT_EQ(table[1].back(), "");
}

TEST_F(ExtractionTableTest, NothingIsWrittenUnlessAskedOrBeforeTheFirstScan) {
  const LookedAt seen(scene_, nullptr);
  {
    ExtractionTable none(Config::parse("{}"), "extraction_table");
    none.take({Time{}, seen.observation.view, seen.candidates});
    const ExtractionTable unused(config(), "extraction_table");
  }
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_FALSE(std::filesystem::exists(file_.parent_path())) << "a folder of who only looked";
}

TEST_F(ExtractionTableTest, AFolderThatCannotBeMadeIsAnErrorOfTheFirstScan) {
  std::ofstream(folder_ / "in") << "a file";
  EXPECT_THROW(write(LookedAt(scene_, nullptr), false), Error);
}

TEST_F(ExtractionTableTest, AFileAnywhereNeedsAPermission) {
  const Config config = Config::parse("{ extraction_table: " + file_.string() + " }");
  EXPECT_THROW(ExtractionTable(config, "extraction_table"), ConfigError);
}

}  // namespace
}  // namespace waymark::feature_map
