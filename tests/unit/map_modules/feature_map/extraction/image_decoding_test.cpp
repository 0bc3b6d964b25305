// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/image_decoding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "map_modules/feature_map/extraction/image_size.hpp"

namespace waymark::feature_map {
namespace {

constexpr int kWidth = 31;
constexpr int kHeight = 17;

Intrinsics intrinsics() {
  Intrinsics intrinsics;
  intrinsics.width = kWidth;
  intrinsics.height = kHeight;
  return intrinsics;
}

/// Pixels of all values in no order.
Image pixels(Image::Encoding encoding, std::size_t channels) {
  Image image;
  image.encoding = encoding;
  image.width = kWidth;
  image.height = kHeight;
  for (std::size_t i = 0; i < kWidth * kHeight * channels; ++i)
    image.data.push_back(static_cast<std::uint8_t>(i * i * 37 + i));
  return image;
}

/// The same as a PNG file.
Image as_png(const Image& image) {
  cv::Mat matrix(image.height, image.width, image.encoding == Image::Encoding::mono8 ? CV_8UC1 : CV_8UC3);
  std::copy(image.data.begin(), image.data.end(), matrix.data);
  Image png;
  png.encoding = Image::Encoding::compressed;
  cv::imencode(".png", matrix, png.data);
  return png;
}

void expect_same_pixels(const Image& one, const Image& other) {
  const DecodedImage a = decode(one, intrinsics());
  const DecodedImage b = decode(other, intrinsics());
  ASSERT_EQ(a.state, ImageState::used);
  ASSERT_EQ(b.state, ImageState::used);
  ASSERT_EQ(a.bgr.size(), b.bgr.size());
  ASSERT_EQ(a.bgr.type(), b.bgr.type());
  EXPECT_EQ(cv::norm(a.bgr, b.bgr, cv::NORM_INF), 0.0);
}

TEST(ImageDecoding, APngIsWorthItsPixels) {
  const Image image = pixels(Image::Encoding::bgr8, 3);
  expect_same_pixels(image, as_png(image));
}

TEST(ImageDecoding, AGreyPngToo) {
  const Image image = pixels(Image::Encoding::mono8, 1);
  expect_same_pixels(image, as_png(image));
}

/// An image of any size in a format of OpenCV.
Image as_file(const std::string& extension, int width, int height) {
  Image file;
  file.encoding = Image::Encoding::compressed;
  cv::imencode(extension, cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 120, 60)), file.data);
  return file;
}

TEST(ImageDecoding, TheHeaderTellsTheSize) {
  for (const char* extension : {".png", ".jpg"}) {
    const Image file = as_file(extension, 300, 70);
    EXPECT_EQ(size_in_header(file.data), (ImageSize{300, 70})) << extension;
    for (std::size_t length = 0; length < 24; ++length) {
      EXPECT_EQ(size_in_header(std::span(file.data).first(length)), std::nullopt) << extension << " " << length;
    }
    EXPECT_EQ(decode(file, intrinsics()).state, ImageState::wrong_size) << extension;
    EXPECT_EQ(decode(as_file(extension, kWidth, kHeight), intrinsics()).state, ImageState::used) << extension;
  }
}

TEST(ImageDecoding, OtherFormatsAreNotRead) {
  for (const char* extension : {".bmp", ".tiff", ".ppm", ".webp"})
    EXPECT_EQ(decode(as_file(extension, kWidth, kHeight), intrinsics()).state, ImageState::undecodable) << extension;
  Image nothing;
  nothing.encoding = Image::Encoding::compressed;
  EXPECT_EQ(decode(nothing, intrinsics()).state, ImageState::undecodable);
}

TEST(ImageDecoding, AFileOfAnotherSizeIsNotUnpacked) {
  // 25'000 x 25'000 pixels, by its header: two gigabytes. The pixels are damaged, which only who unpacks them notices.
  Image file = as_file(".png", 400, 400);
  for (const std::size_t at : {16U, 20U}) {
    file.data[at + 2] = 25'000 >> 8;
    file.data[at + 3] = 25'000 & 0xff;
  }
  EXPECT_EQ(decode(file, intrinsics()).state, ImageState::wrong_size);
}

}  // namespace
}  // namespace waymark::feature_map
