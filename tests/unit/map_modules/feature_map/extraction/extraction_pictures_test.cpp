// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/extraction_pictures.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "temporary_folder.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/base/error.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::scan_of;
using feature_map_test::settings_of;
using feature_map_test::World;

class ExtractionPicturesTest : public ::testing::Test {
 protected:
  ExtractionPictures pictures(const std::string& times_s) const {
    const Config config = Config::parse("{ times_s: " + times_s + ", folder: " + (folder_ / "in/it").string() + " }");
    config.permit_outside();
    return ExtractionPictures(config);
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    if (!std::filesystem::exists(folder_ / "in/it")) return names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "in/it"))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  static Time at(double seconds) { return Time{from_seconds(1e9 + seconds)}; }

  test::TemporaryFolder folder_;
  FeatureMapSettings all_settings_ = settings_of("{ extraction: { range_max_m: 20, isolation_m: 2 } }");
  ExtractionSettings settings_ = all_settings_.extraction;
  // One trunk that is accepted, and a pair that is crowded.
  ScanView view_ =
      view_of(scan_of(World{{{{8.0, 4.0}, 0.2}, {{8.0, -4.0}, 0.2}, {{8.0, -5.5}, 0.2}}, {}}), {}, settings_);
  std::vector<Candidate> candidates_ = examine(view_, settings_);
};

/// How many pixels have about this colour (red, green, blue).
int count_pixels(const cv::Mat& image, const Eigen::Vector3i& color) {
  int count = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const auto& bgr = image.at<cv::Vec3b>(y, x);
      count += (Eigen::Vector3i(bgr[2], bgr[1], bgr[0]) - color).cwiseAbs().maxCoeff() < 20 ? 1 : 0;
    }
  }
  return count;
}

TEST_F(ExtractionPicturesTest, DrawsTheFirstScanNotEarlierThanEachTime) {
  ExtractionPictures taken = pictures("[0, 2.5]");
  taken.take({at(0.0), view_, candidates_}, all_settings_);
  EXPECT_EQ(files(), (std::vector<std::string>{"scan_0s.png"}));
  taken.take({at(2.0), view_, candidates_}, all_settings_);
  EXPECT_EQ(files().size(), 1u);
  taken.take({at(3.0), view_, candidates_}, all_settings_);
  EXPECT_EQ(files(), (std::vector<std::string>{"scan_0s.png", "scan_2.5s.png"}));
}

TEST_F(ExtractionPicturesTest, WithoutTimesNothingIsWritten) {
  ExtractionPictures none = pictures("[]");
  none.take({at(0.0), view_, candidates_}, all_settings_);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(ExtractionPicturesTest, DroppedCandidatesHaveTheColourOfTheirReason) {
  const auto red_pixels = [&](const ExtractionSettings& settings) {
    const std::string png = draw_extraction(view_, examine(view_, settings), settings, "");
    const std::vector<unsigned char> bytes(png.begin(), png.end());
    return count_pixels(cv::imdecode(bytes, cv::IMREAD_COLOR), {210, 40, 40});
  };
  ExtractionSettings unasked = settings_;
  unasked.isolation = 0.0;
  // The legend's own dot is in both.
  EXPECT_GT(red_pixels(settings_), red_pixels(unasked) + 20);
}

TEST_F(ExtractionPicturesTest, TimesThatDoNotAscendAreRefused) { EXPECT_THROW(pictures("[3, 1]"), ConfigError); }

TEST_F(ExtractionPicturesTest, AFolderThatCannotBeMadeIsAnErrorOfTheFirstPicture) {
  std::ofstream(folder_ / "in") << "a file";
  ExtractionPictures taken = pictures("[0]");
  EXPECT_THROW(taken.take({at(0.0), view_, candidates_}, all_settings_), Error);
}

}  // namespace
}  // namespace waymark::feature_map
