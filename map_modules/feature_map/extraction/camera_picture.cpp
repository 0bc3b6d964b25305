// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/camera_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "map_modules/feature_map/extraction/picture_colors.hpp"
#include "waymark/base/error.hpp"

namespace waymark::feature_map {

namespace {

const cv::Scalar kGreen(60, 200, 40);  // (blue, green, red)
const cv::Scalar kRed(40, 40, 230);
const cv::Scalar kOther(220, 200, 60);
constexpr int kTitleHeight = 40;
constexpr int kPanel = 330;  // width of the histograms
constexpr int kRowHeight = 74;
constexpr int kPanelMargin = 12;

void text(cv::Mat& picture, const cv::Point& at, const std::string& words, double size, const cv::Scalar& color) {
  cv::putText(picture, words, at, cv::FONT_HERSHEY_SIMPLEX, size, color, 1, cv::LINE_AA);
}

cv::Point rounded(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
}

/// The colour that stands for a bin: its middle, at full value.
cv::Scalar color_of(int hue_bin, int saturation_bin, const CameraSettings& settings) {
  const cv::Mat hsv(1, 1, CV_8UC3,
                    cv::Scalar(hue_bin * 180.0 / settings.hue_bins,
                               (saturation_bin + 0.5) * 255.0 / settings.saturation_bins, 235.0));
  cv::Mat bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  const auto& pixel = bgr.at<cv::Vec3b>(0, 0);
  return {static_cast<double>(pixel[0]), static_cast<double>(pixel[1]), static_cast<double>(pixel[2])};
}

void draw_returns(cv::Mat& area, const ScanView& view, const Pose& T_base_scanner,
                  const std::vector<Candidate>& candidates, const CameraView& camera) {
  std::vector<cv::Scalar> colors(view.ranges.size(), kOther);
  for (const Candidate& candidate : candidates) {
    if (candidate.verdict != Verdict::accepted && candidate.verdict != Verdict::no_edges) continue;
    for (int beam = candidate.first_beam; beam <= candidate.last_beam; ++beam)
      colors[static_cast<std::size_t>(beam)] = candidate.verdict == Verdict::accepted ? kGreen : kRed;
  }
  for (std::size_t beam = 0; beam < view.ranges.size(); ++beam) {
    const double range = view.ranges[beam];
    if (!std::isfinite(range) || range <= 0.0) continue;
    const double bearing = view.start + static_cast<double>(beam) * view.step;
    const auto pixel =
        camera.project(T_base_scanner * Eigen::Vector3d(range * std::cos(bearing), range * std::sin(bearing), 0.0));
    if (pixel && camera.shows(*pixel)) cv::circle(area, rounded(*pixel), 2, colors[beam], cv::FILLED, cv::LINE_AA);
  }
}

void draw_region(cv::Mat& area, const CandidateLook& look, int number) {
  std::vector<cv::Point> outline;
  outline.reserve(look.corners.size());
  for (const Eigen::Vector2d& corner : look.corners) outline.push_back(rounded(corner));
  const cv::Scalar& color = look.has_edges ? kGreen : kRed;
  cv::polylines(area, std::vector<std::vector<cv::Point>>{outline}, true, color, 2, cv::LINE_AA);
  text(area, outline.front() + cv::Point(0, -5), std::to_string(number), 0.5, color);
}

void draw_histogram(cv::Mat& picture, const cv::Point& corner, const Signature& signature,
                    const CameraSettings& settings) {
  constexpr int kHeight = 44;
  const int bins = settings.hue_bins * settings.saturation_bins;
  const double width = static_cast<double>(kPanel - 2 * kPanelMargin) / bins;
  cv::line(picture, corner + cv::Point(0, kHeight), corner + cv::Point(kPanel - 2 * kPanelMargin, kHeight), kGrid);
  if (signature.empty()) {
    text(picture, corner + cv::Point(0, kHeight - 4), "unknown: too dark", 0.45, kInk);
    return;
  }
  const double most = *std::max_element(signature.begin(), signature.end());
  for (int bin = 0; bin < bins; ++bin) {
    const int height =
        static_cast<int>(std::lround(kHeight * static_cast<double>(signature[static_cast<std::size_t>(bin)]) / most));
    if (height == 0) continue;
    const cv::Rect bar(corner.x + static_cast<int>(bin * width), corner.y + kHeight - height,
                       std::max(1, static_cast<int>(std::ceil(width))), height);
    cv::rectangle(picture, bar, color_of(bin / settings.saturation_bins, bin % settings.saturation_bins, settings),
                  cv::FILLED);
    cv::rectangle(picture, bar, kInk);
  }
}

}  // namespace

std::string draw_look(const ScanView& view, const Pose& T_base_scanner, const std::vector<Candidate>& candidates,
                      const ImageLook& look, const CameraSettings& settings, const std::string& title) {
  const cv::Mat& image = look.image.bgr;
  const auto accepted = static_cast<int>(std::ranges::count(look.looks, true, &CandidateLook::has_edges));
  const int height = kTitleHeight + std::max(image.rows, accepted * kRowHeight + kPanelMargin);
  cv::Mat picture(height, image.cols + kPanel, CV_8UC3, cv::Scalar(255, 255, 255));
  cv::Mat area = picture(cv::Rect(0, kTitleHeight, image.cols, image.rows));
  image.copyTo(area);
  if (look.camera) draw_returns(area, view, T_base_scanner, candidates, *look.camera);

  int number = 0;
  int row = kTitleHeight;
  for (const CandidateLook& one : look.looks) {
    draw_region(area, one, ++number);
    if (!one.has_edges) continue;
    text(picture, {image.cols + kPanelMargin, row + 16},
         fmt::format("{}: radius {:.3f} m, sigma {:.3f} m", number, candidates[one.candidate].radius, one.radius_sigma),
         0.45, kInk);
    draw_histogram(picture, {image.cols + kPanelMargin, row + 22}, one.signature, settings);
    row += kRowHeight;
  }
  text(picture, {kPanelMargin, 26},
       fmt::format("{}: {} with edges, {} without", title, accepted, static_cast<int>(look.looks.size()) - accepted),
       0.6, kInk);

  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes)) throw Error("a picture of a camera's candidates cannot be encoded as PNG");
  return {bytes.begin(), bytes.end()};
}

}  // namespace waymark::feature_map
