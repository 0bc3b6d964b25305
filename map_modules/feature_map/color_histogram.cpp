// SPDX-License-Identifier: Apache-2.0
#include "color_histogram.hpp"

#include <opencv2/imgproc.hpp>

namespace waymark {

Signature hue_saturation(const cv::Mat& bgr, const CameraSettings& settings) {
  constexpr int kHues = 180;  // of OpenCV: 2° each
  constexpr int kSaturations = 256;
  constexpr int kFewest = 8;            // pixels that make a histogram
  constexpr double kFewestShare = 0.1;  // of the region
  if (bgr.empty()) return {};
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  const int value_min = static_cast<int>(255.0 * settings.value_min);
  const auto saturations = static_cast<std::size_t>(settings.saturation_bins);
  Signature histogram = Signature::uniform(static_cast<std::size_t>(settings.hue_bins) * saturations);
  for (float& bin : histogram) bin = 0.0f;
  int counted = 0;
  for (int y = 0; y < hsv.rows; ++y) {
    const auto* row = hsv.ptr<cv::Vec3b>(y);
    for (int x = 0; x < hsv.cols; ++x) {
      if (row[x][2] < value_min) continue;
      const int hue = (row[x][0] * settings.hue_bins + kHues / 2) / kHues % settings.hue_bins;
      const int saturation = row[x][1] * settings.saturation_bins / kSaturations;
      histogram[static_cast<std::size_t>(hue) * saturations + static_cast<std::size_t>(saturation)] += 1.0f;
      ++counted;
    }
  }
  if (counted < kFewest || counted < kFewestShare * static_cast<double>(hsv.total())) return {};
  for (float& bin : histogram) bin /= static_cast<float>(counted);
  return histogram;
}

}  // namespace waymark
