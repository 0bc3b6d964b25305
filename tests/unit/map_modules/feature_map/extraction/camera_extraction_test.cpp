// SPDX-License-Identifier: Apache-2.0
// Candidates of a scan in an image whose every pixel is known.
#include "map_modules/feature_map/extraction/camera_extraction.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <opencv2/imgcodecs.hpp>

#include "tests/unit/map_modules/feature_map/camera_bench.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::camera_settings;
using feature_map_test::CameraScene;
using feature_map_test::kBluePaint;
using feature_map_test::kRedPaint;
using feature_map_test::LookedAt;
using feature_map_test::Painted;

LookedAt looked_at(const CameraScene& scene, const std::string& camera = "") {
  const Measurement image = scene.image(scene.picture());
  return {scene, &image, camera_settings(camera)};
}

/// The same things for the scanner, none of them for the camera.
Measurement image_of_nothing(CameraScene scene) {
  scene.things.clear();
  return scene.image(scene.picture());
}

TEST(CameraExtraction, MeasuresTheRadiusBetweenTheEdges) {
  const auto seen = looked_at({{{{5.0, 0.4}, 0.2, kRedPaint}}});
  ASSERT_EQ(seen.observation.detections.size(), 1u);
  EXPECT_NEAR(seen.observation.detections[0].xyr.z(), 0.2, 0.006);  // a pixel is 5 mm there
  EXPECT_NEAR(seen.observation.detections[0].xyr.x(), 5.0, 0.05);
  EXPECT_NEAR(seen.observation.detections[0].xyr.y(), 0.4, 0.05);
}

// Beams of half a degree count a width of 2 to 10 beams; the image has eight times as many pixels.
TEST(CameraExtraction, IsSeveralTimesFinerThanTheScan) {
  double square_of_scan = 0.0;
  double square_of_image = 0.0;
  int count = 0;
  for (const double x : {4.0, 5.3, 6.1, 7.7, 8.9}) {
    for (const double radius : {0.12, 0.17, 0.23}) {
      const auto seen = looked_at({{{{x, 0.1 * x - 0.4}, radius, kBluePaint}}});
      ASSERT_EQ(seen.observation.detections.size(), 1u) << x << ' ' << radius;
      square_of_scan += std::pow(seen.by_scan.at(0).radius - radius, 2);
      square_of_image += std::pow(seen.observation.detections[0].xyr.z() - radius, 2);
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(square_of_image / count), 0.006);
  EXPECT_LT(square_of_image, square_of_scan / 9.0);
}

TEST(CameraExtraction, TheNoiseOfTheRadiusGrowsWithDistance) {
  const auto sigma = [](double x) {
    return std::sqrt(looked_at({{{{x, 0.0}, 0.2, kRedPaint}}}).observation.detections.at(0).R(2, 2));
  };
  EXPECT_NEAR(sigma(4.0), 4.0 * std::sqrt(2.0) / 500.0 / 2.0, 0.002);
  EXPECT_GT(sigma(10.0), 2.0 * sigma(4.0));
  EXPECT_LT(sigma(10.0), 0.1);  // of the scan alone
}

TEST(CameraExtraction, TheSignatureIsTheColourOfTheRegion) {
  const auto seen =
      looked_at({{{{5.0, 1.0}, 0.2, kRedPaint}, {{6.0, -1.0}, 0.2, kBluePaint}}}, "hue_bins: 6, saturation_bins: 2");
  ASSERT_EQ(seen.observation.detections.size(), 2u);
  const Signature& right = seen.observation.detections[0].signature;
  const Signature& left = seen.observation.detections[1].signature;
  for (const Signature* signature : {&left, &right}) {
    ASSERT_EQ(signature->size(), 12u);
    EXPECT_NEAR(std::accumulate(signature->begin(), signature->end(), 0.0), 1.0, 1e-5);
  }
  EXPECT_GT(left[1], 0.95f);
  EXPECT_GT(right[3 * 2 + 1] + right[4 * 2 + 1], 0.95f);
}

TEST(CameraExtraction, WithoutEdgesACandidateIsDiscarded) {
  const CameraScene scene{{{{5.0, 0.4}, 0.2, kRedPaint}}};
  const Measurement image = image_of_nothing(scene);
  const LookedAt seen(scene, &image);
  EXPECT_EQ(seen.by_scan.at(0).verdict, Verdict::accepted);
  EXPECT_EQ(seen.candidates.at(0).verdict, Verdict::no_edges);
  EXPECT_TRUE(seen.observation.detections.empty());
}

TEST(CameraExtraction, WhatIsMuchWiderInTheImageIsAnotherThing) {
  const CameraScene scene{{{{6.0, 0.0}, 0.15, kRedPaint}}};
  CameraScene wider = scene;
  wider.things[0].radius = 0.3;
  const Measurement image = scene.image(wider.picture());
  const std::string wide_search = "edge_search_deg: 4, ";
  EXPECT_EQ(LookedAt(scene, &image, camera_settings(wide_search + "width_ratio_max: 1.5")).candidates.at(0).verdict,
            Verdict::no_edges);
  EXPECT_EQ(LookedAt(scene, &image, camera_settings(wide_search + "width_ratio_max: 3")).candidates.at(0).verdict,
            Verdict::accepted);
}

TEST(CameraExtraction, ContrastBelowTheThresholdIsNoEdge) {
  const CameraScene scene{{{{5.0, 0.4}, 0.2, {105, 120, 110}}}};  // hardly other than the ground
  EXPECT_EQ(looked_at(scene, "edge_min_contrast: 30").candidates.at(0).verdict, Verdict::no_edges);
  EXPECT_EQ(looked_at(scene, "edge_min_contrast: 10").candidates.at(0).verdict, Verdict::accepted);
}

// The scan is at 0.6 m; a share of 0.75 of the rows from 0.35 to 1.35 m must show the edge.
TEST(CameraExtraction, WhatEndsWithinTheHeightIsNoPole) {
  const auto verdict_of = [](double height, const std::string& cover) {
    const auto seen =
        looked_at({{{{4.0, 0.3}, 0.15, kRedPaint, height}}}, "edge_below_m: 0.25, edge_above_m: 0.75" + cover);
    return seen.candidates.at(0).verdict;
  };
  EXPECT_EQ(verdict_of(2.0, ""), Verdict::accepted);
  EXPECT_EQ(verdict_of(0.8, ""), Verdict::no_edges);
  EXPECT_EQ(verdict_of(0.8, ", edge_min_cover: 0.3"), Verdict::accepted);
}

TEST(CameraExtraction, TakesTheLensDistortionIntoAccount) {
  for (const double k1 : {-0.30, 0.15}) {
    CameraScene scene{{{{4.0, 1.7}, 0.2, kRedPaint}, {{4.0, -1.6}, 0.2, kBluePaint}}};
    scene.intrinsics.distortion = {k1, 0.05, 0.002, -0.001, 0.0};
    const Measurement image = scene.image(scene.picture());
    const LookedAt seen(scene, &image);
    ASSERT_EQ(seen.observation.detections.size(), 2u) << k1;
    for (const Detection& detection : seen.observation.detections) EXPECT_NEAR(detection.xyr.z(), 0.2, 0.008) << k1;

    CameraScene ignorant = scene;
    ignorant.intrinsics.distortion = {};
    for (const Detection& detection : LookedAt(ignorant, &image).observation.detections)
      EXPECT_GT(std::abs(detection.xyr.z() - 0.2), 0.008) << "the distortion of this test makes no difference";
  }
}

TEST(CameraExtraction, MovesTheCandidatesByTheMotionSinceTheImage) {
  const CameraScene scene{{{{5.0, 0.4}, 0.2, kRedPaint}}};
  const MotionWindow motion{{2.0, 0.0, 0.0}, {0.0, 0.0, 0.8}};
  const double age = 0.12;
  const Measurement image = scene.image(scene.picture(motion.relative(-age)), -age);
  const LookedAt seen(scene, &image, camera_settings(), motion);
  ASSERT_EQ(seen.observation.detections.size(), 1u);
  EXPECT_NEAR(seen.observation.detections[0].xyr.z(), 0.2, 0.006);
  EXPECT_TRUE(LookedAt(scene, &image).observation.detections.empty());  // 5° aside
}

TEST(CameraExtraction, OutsideOfTheImageTheScanHasTheLastWordUnlessTold) {
  const CameraScene scene{{{{1.0, 6.0}, 0.2, kRedPaint}, {{5.0, 0.0}, 0.2, kRedPaint}}};
  const auto kept = looked_at(scene);
  ASSERT_EQ(kept.observation.detections.size(), 2u);
  EXPECT_FALSE(kept.observation.detections[0].signature.empty());
  EXPECT_TRUE(kept.observation.detections[1].signature.empty());
  EXPECT_EQ(kept.observation.detections[1].xyr.z(), kept.by_scan.at(1).radius);
  EXPECT_NEAR(kept.observation.detections[1].R(2, 2), 0.01, 1e-9);
  EXPECT_TRUE(kept.observation.detections[0].may_be_new);
  EXPECT_FALSE(kept.observation.detections[1].may_be_new);
  EXPECT_TRUE(looked_at(scene, "unseen: keep").observation.detections[1].may_be_new);

  const auto dropped = looked_at(scene, "unseen: drop");
  EXPECT_EQ(dropped.observation.detections.size(), 1u);
  EXPECT_EQ(dropped.candidates.at(1).verdict, Verdict::off_image);
}

TEST(CameraExtraction, ABlackThingHasEdgesButNoColour) {
  const auto seen = looked_at({{{{5.0, 0.4}, 0.2, {8, 8, 8}}}});
  ASSERT_EQ(seen.observation.detections.size(), 1u);
  EXPECT_TRUE(seen.observation.detections[0].signature.empty());
  EXPECT_NEAR(seen.observation.detections[0].xyr.z(), 0.2, 0.006);
}

// --- images that are not usable
// -----------------------------------------------------------------------------------------

class BadImages : public ::testing::Test {
 protected:
  /// Nothing but the counts may differ from a scan alone, and reflectivity is not mixed with colours.
  void expect_scan_alone(const Measurement* image, ImageState state) const {
    const LookedAt seen(scene_, image);
    EXPECT_EQ(seen.look.image.state, state);
    ASSERT_EQ(seen.observation.detections.size(), 1u);
    EXPECT_EQ(seen.observation.detections[0].xyr.z(), seen.by_scan.at(0).radius);
    EXPECT_TRUE(seen.observation.detections[0].signature.empty());
  }
  void expect_scan_alone(const Image& image, ImageState state) const {
    const Measurement m = CameraScene::measurement(std::make_shared<Image>(image), 0.0);
    expect_scan_alone(&m, state);
  }
  Measurement uniform(int level) const {
    return scene_.image(cv::Mat(480, 640, CV_8UC3, cv::Scalar(level, level, level)));
  }
  Image compressed(const cv::Mat& bgr, const char* kind) const {
    Image image;
    image.encoding = Image::Encoding::compressed;
    cv::imencode(kind, bgr, image.data);
    return image;
  }

  CameraScene scene_{{{{5.0, 0.4}, 0.2, kRedPaint}}};
};

TEST_F(BadImages, NoneThatIsFreshEnough) { expect_scan_alone(nullptr, ImageState::missing); }

TEST_F(BadImages, Black) {
  const Measurement image = uniform(3);
  expect_scan_alone(&image, ImageState::dark);
}

TEST_F(BadImages, Overexposed) {
  const Measurement image = uniform(255);
  expect_scan_alone(&image, ImageState::overexposed);
}

TEST_F(BadImages, WrongSize) {
  const cv::Mat half(240, 320, CV_8UC3, cv::Scalar(90, 90, 90));
  const Measurement image = scene_.image(half);
  expect_scan_alone(&image, ImageState::wrong_size);
  expect_scan_alone(compressed(half, ".png"), ImageState::wrong_size);
}

TEST_F(BadImages, FewerBytesThanItsSizeTakes) {
  Image image = scene_.image(scene_.picture()).as<Image>();
  image.data.pop_back();
  expect_scan_alone(image, ImageState::wrong_size);
}

TEST_F(BadImages, Undecodable) {
  Image image = compressed(scene_.picture(), ".png");
  image.data[0] ^= 0xffu;
  expect_scan_alone(image, ImageState::undecodable);
  image.data.clear();
  expect_scan_alone(image, ImageState::undecodable);
}

TEST_F(BadImages, WhileCompressedAndGreyOnesAreGood) {
  const cv::Mat bgr = scene_.picture();
  const Measurement jpeg = CameraScene::measurement(std::make_shared<Image>(compressed(bgr, ".jpg")), 0.0);
  const LookedAt by_jpeg(scene_, &jpeg);
  ASSERT_EQ(by_jpeg.observation.detections.size(), 1u);
  EXPECT_NEAR(by_jpeg.observation.detections[0].xyr.z(), 0.2, 0.006);

  Image grey;
  grey.encoding = Image::Encoding::mono8;
  grey.width = bgr.cols;
  grey.height = bgr.rows;
  for (auto pixel = bgr.begin<cv::Vec3b>(); pixel != bgr.end<cv::Vec3b>(); ++pixel) grey.data.push_back((*pixel)[2]);
  const Measurement mono = CameraScene::measurement(std::make_shared<Image>(grey), 0.0);
  const LookedAt by_grey(scene_, &mono);
  ASSERT_EQ(by_grey.observation.detections.size(), 1u);
  EXPECT_NEAR(by_grey.observation.detections[0].xyr.z(), 0.2, 0.006);
}

}  // namespace
}  // namespace waymark::feature_map
