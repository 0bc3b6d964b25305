// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/image_decoding.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "map_modules/feature_map/extraction/image_size.hpp"

namespace waymark::feature_map {

namespace {

cv::Mat decompress(const std::vector<std::uint8_t>& file) {
  try {
    return cv::imdecode(file, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};  // how OpenCV reports some damaged files
  }
}

ImageState exposure_of(const cv::Mat& bgr) {
  constexpr int kStride = 4;  // enough pixels to judge by
  constexpr int kBlack = 16;
  constexpr int kWhite = 250;
  constexpr double kNearlyAll = 0.95;
  int seen = 0;
  int black = 0;
  int white = 0;
  for (int y = 0; y < bgr.rows; y += kStride) {
    const auto* row = bgr.ptr<cv::Vec3b>(y);
    for (int x = 0; x < bgr.cols; x += kStride) {
      const auto [low, high] = std::minmax({row[x][0], row[x][1], row[x][2]});
      ++seen;
      black += high < kBlack;
      white += low > kWhite;
    }
  }
  if (black > kNearlyAll * seen) return ImageState::dark;
  if (white > kNearlyAll * seen) return ImageState::overexposed;
  return ImageState::used;
}

}  // namespace

DecodedImage decode(const Image& image, const Intrinsics& intrinsics) {
  cv::Mat bgr;
  if (image.encoding == Image::Encoding::compressed) {
    // Before decoding: what a file unpacks to has no bound but this one.
    const std::optional<ImageSize> size = size_in_header(image.data);
    if (!size) return {ImageState::undecodable, {}};
    if (*size != ImageSize{intrinsics.width, intrinsics.height}) return {ImageState::wrong_size, {}};
    bgr = decompress(image.data);
    if (bgr.empty()) return {ImageState::undecodable, {}};
    if (bgr.cols != intrinsics.width || bgr.rows != intrinsics.height) return {ImageState::wrong_size, {}};
  } else {
    const bool mono = image.encoding == Image::Encoding::mono8;
    const std::size_t bytes =
        static_cast<std::size_t>(intrinsics.width) * static_cast<std::size_t>(intrinsics.height) * (mono ? 1 : 3);
    if (image.width != intrinsics.width || image.height != intrinsics.height || image.data.size() != bytes)
      return {ImageState::wrong_size, {}};
    bgr.create(image.height, image.width, CV_8UC3);
    if (mono) {
      // OpenCV has no view of constant bytes; a copy of one channel is cheap.
      cv::Mat gray(image.height, image.width, CV_8UC1);
      std::copy(image.data.begin(), image.data.end(), gray.data);
      cv::cvtColor(gray, bgr, cv::COLOR_GRAY2BGR);
    } else {
      std::copy(image.data.begin(), image.data.end(), bgr.data);
    }
  }
  const ImageState exposure = exposure_of(bgr);
  return {exposure, std::move(bgr)};
}

}  // namespace waymark::feature_map
