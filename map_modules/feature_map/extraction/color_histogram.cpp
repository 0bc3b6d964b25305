// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/color_histogram.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace waymark::feature_map {

namespace {

/// A pixel's vote for the two bins whose middles it lies between.
struct Vote {
  int first;
  int second;
  float share_of_second;
};

/// `position` counted in bins, whole numbers in their middles; the bins go round in a circle or end.
Vote vote(float position, int bins, bool circular) {
  const float below = std::floor(position);
  const auto first = static_cast<int>(below);
  if (circular) return {(first + bins) % bins, (first + 1) % bins, position - below};
  return {std::clamp(first, 0, bins - 1), std::clamp(first + 1, 0, bins - 1), position - below};
}

/// The votes for all values of one channel.
template <std::size_t N>
std::array<Vote, N> votes(float bins_per_value, float shift, int bins, bool circular) {
  std::array<Vote, N> table;
  for (std::size_t i = 0; i < N; ++i) table[i] = vote(static_cast<float>(i) * bins_per_value + shift, bins, circular);
  return table;
}

}  // namespace

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
  const auto hue_votes = votes<kHues>(static_cast<float>(settings.hue_bins) / kHues, 0.0f, settings.hue_bins, true);
  const auto saturation_votes = votes<kSaturations>(static_cast<float>(settings.saturation_bins) / kSaturations, -0.5f,
                                                    settings.saturation_bins, false);
  Signature histogram = Signature::uniform(static_cast<std::size_t>(settings.hue_bins) * saturations);
  for (float& bin : histogram) bin = 0.0f;
  int counted = 0;
  for (int y = 0; y < hsv.rows; ++y) {
    const auto* row = hsv.ptr<cv::Vec3b>(y);
    for (int x = 0; x < hsv.cols; ++x) {
      if (row[x][2] < value_min) continue;
      const Vote& hue = hue_votes[std::min<std::size_t>(row[x][0], kHues - 1)];
      const Vote& saturation = saturation_votes[row[x][1]];
      const auto add = [&](int h, int s, float share) {
        histogram[static_cast<std::size_t>(h) * saturations + static_cast<std::size_t>(s)] += share;
      };
      const float h = hue.share_of_second;
      const float s = saturation.share_of_second;
      add(hue.first, saturation.first, (1.0f - h) * (1.0f - s));
      add(hue.first, saturation.second, (1.0f - h) * s);
      add(hue.second, saturation.first, h * (1.0f - s));
      add(hue.second, saturation.second, h * s);
      ++counted;
    }
  }
  if (counted < kFewest || counted < kFewestShare * static_cast<double>(hsv.total())) return {};
  for (float& bin : histogram) bin /= static_cast<float>(counted);
  return histogram;
}

}  // namespace waymark::feature_map
