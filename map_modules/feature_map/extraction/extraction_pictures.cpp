// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/extraction_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "map_modules/feature_map/extraction/camera_picture.hpp"
#include "map_modules/feature_map/extraction/picture_colors.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::feature_map {

namespace {

/// How one verdict looks; cv::Scalar is (blue, green, red).
struct Look {
  Verdict verdict;
  const char* words;
  cv::Scalar color;
};

const std::array<Look, kVerdicts>& looks() {
  static const std::array<Look, kVerdicts> all{{
      {Verdict::accepted, "accepted", {60, 140, 20}},
      {Verdict::crowded, "crowded", {40, 40, 210}},
      {Verdict::no_background, "no background", {20, 140, 240}},
      {Verdict::hidden, "hidden", {190, 60, 160}},
      {Verdict::too_few_beams, "too few beams", {200, 170, 30}},
      {Verdict::too_wide, "too wide", {200, 90, 40}},
      {Verdict::too_far, "too far", {170, 170, 170}},
      {Verdict::no_edges, "no edges", {110, 30, 110}},
      {Verdict::off_image, "off the image", {120, 120, 60}},
  }};
  return all;
}

const Look& look_of(Verdict verdict) {
  return *std::find_if(looks().begin(), looks().end(), [&](const Look& look) { return look.verdict == verdict; });
}

constexpr int kWidth = 1200;
constexpr int kLegend = 210;
constexpr int kMargin = 24;
constexpr int kTop = 44;
constexpr int kShift = 4;  // OpenCV's fixed point: sixteenths of a pixel

class Painter {
 public:
  Painter(const ScanView& view, double range_max) : view_(view) {
    low_ = high_ = Eigen::Vector2d::Zero();
    for (int i = 0; i < static_cast<int>(view.ranges.size()); ++i) {
      const double r = view.ranges[static_cast<std::size_t>(i)];
      if (!std::isfinite(r) || r > range_max) continue;
      low_ = low_.cwiseMin(point(i));
      high_ = high_.cwiseMax(point(i));
    }
    constexpr double kBorder = 2.0;  // [m]
    low_.array() -= kBorder;
    high_.array() += kBorder;
    scale_ = (kWidth - kLegend - 2 * kMargin) / (high_.y() - low_.y());
    constexpr double kTallest = 1400.0;
    scale_ = std::min(scale_, kTallest / (high_.x() - low_.x()));
    const int height = kTop + kMargin + std::max(260, static_cast<int>(scale_ * (high_.x() - low_.x())));
    image_ = cv::Mat(height, kWidth, CV_8UC3, cv::Scalar(255, 255, 255));
  }

  Eigen::Vector2d point(int beam) const {
    const double bearing = view_.start + beam * view_.step;
    return view_.ranges[static_cast<std::size_t>(beam)] * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
  }

  void draw_rings() {
    const double reach = std::max(low_.cwiseAbs().maxCoeff(), high_.cwiseAbs().maxCoeff());
    const double step = reach > 25.0 ? 10.0 : (reach > 10.0 ? 5.0 : 1.0);
    for (double r = step; r < 1.5 * reach; r += step) {
      circle(Eigen::Vector2d::Zero(), r, kGrid, 1);
      const Eigen::Vector2d label(r, 0.0);
      if (r < high_.x()) text(to_pixel(label) + Eigen::Vector2d(3, -3), fmt::format("{:g} m", r), 0.4, {150, 145, 140});
    }
    const std::array<Eigen::Vector2d, 3> robot{Eigen::Vector2d(0.8, 0), Eigen::Vector2d(-0.5, 0.45),
                                               Eigen::Vector2d(-0.5, -0.45)};
    std::vector<cv::Point> corners;
    corners.reserve(robot.size());
    for (const Eigen::Vector2d& corner : robot) corners.push_back(fixed(to_pixel(corner)));
    cv::fillPoly(image_, std::vector<std::vector<cv::Point>>{corners}, kInk, cv::LINE_AA, kShift);
  }

  void draw(const Candidate& candidate) {
    const Look& look = look_of(candidate.verdict);
    for (int i = candidate.first_beam; i <= candidate.last_beam; ++i) {
      const Eigen::Vector2d p = point(i);
      if ((p.array() < low_.array()).any() || (p.array() > high_.array()).any()) continue;
      cv::circle(image_, fixed(to_pixel(p)), 2 << kShift, look.color, cv::FILLED, cv::LINE_AA, kShift);
    }
    if (candidate.verdict != Verdict::accepted) return;
    const Eigen::Vector2d direction(std::cos(candidate.bearing), std::sin(candidate.bearing));
    const Eigen::Vector2d center = (candidate.surface_range + candidate.radius) * direction;
    circle(center, std::max(candidate.radius, 8.0 / scale_), look.color, 1);
  }

  void draw_legend(const std::vector<Candidate>& candidates, double isolation, const std::string& title) {
    text({kMargin, 28}, title, 0.6, kInk);
    double y = kTop + 24;
    const double x = kWidth - kLegend;
    for (const Look& look : looks()) {
      const auto count = std::count_if(candidates.begin(), candidates.end(),
                                       [&](const Candidate& c) { return c.verdict == look.verdict; });
      cv::circle(image_, fixed({x, y - 5}), 5 << kShift, look.color, cv::FILLED, cv::LINE_AA, kShift);
      text({x + 14, y}, fmt::format("{} {}", count, look.words), 0.5, kInk);
      y += 26;
    }
    text({x, y + 4}, isolation > 0.0 ? fmt::format("isolation {:g} m", isolation) : "isolation not asked", 0.42, kInk);
  }

  std::string png() const {
    std::vector<unsigned char> bytes;
    if (!cv::imencode(".png", image_, bytes)) throw Error("a picture of an extraction cannot be encoded as PNG");
    return {bytes.begin(), bytes.end()};
  }

 private:
  Eigen::Vector2d to_pixel(const Eigen::Vector2d& p) const {
    return {kMargin + scale_ * (high_.y() - p.y()), kTop + scale_ * (high_.x() - p.x())};
  }
  static cv::Point fixed(const Eigen::Vector2d& pixel) {
    return {static_cast<int>(std::lround(pixel.x() * (1 << kShift))),
            static_cast<int>(std::lround(pixel.y() * (1 << kShift)))};
  }
  void circle(const Eigen::Vector2d& center, double radius, const cv::Scalar& color, int width) {
    cv::Mat area = image_(cv::Rect(0, kTop, kWidth - kLegend - kMargin / 2, image_.rows - kTop));
    constexpr int kCorners = 180;
    std::vector<cv::Point> outline;
    outline.reserve(kCorners);
    for (int k = 0; k < kCorners; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kCorners;
      const Eigen::Vector2d p = center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      outline.push_back(fixed(to_pixel(p) - Eigen::Vector2d(0, kTop)));
    }
    cv::polylines(area, outline, true, color, width, cv::LINE_AA, kShift);
  }
  void text(const Eigen::Vector2d& at, const std::string& words, double size, const cv::Scalar& color) {
    cv::putText(image_, words, {static_cast<int>(at.x()), static_cast<int>(at.y())}, cv::FONT_HERSHEY_SIMPLEX, size,
                color, 1, cv::LINE_AA);
  }

  const ScanView& view_;
  Eigen::Vector2d low_;
  Eigen::Vector2d high_;
  double scale_ = 1.0;
  cv::Mat image_;
};

}  // namespace

std::string draw_extraction(const ScanView& view, const std::vector<Candidate>& candidates,
                            const ExtractionSettings& settings, const std::string& title) {
  Painter painter(view, settings.range_max);
  painter.draw_rings();
  for (const bool accepted : {false, true}) {  // what was accepted lies on top
    for (const Candidate& candidate : candidates) {
      if ((candidate.verdict == Verdict::accepted) == accepted) painter.draw(candidate);
    }
  }
  painter.draw_legend(candidates, settings.isolation, title);
  return painter.png();
}

ExtractionPictures::ExtractionPictures(const Config& config)
    : times_s_(config.numbers(
          {"times_s", "s",
           "scans to draw, counted from the first scan: `scan_Ts.png`, and with a camera `camera_Ts.png`"},
          -1, {})) {
  folder_ =
      config.output({"folder", "where the pictures are written to, relative to the working directory"}, "extraction");
  if (!std::is_sorted(times_s_.begin(), times_s_.end())) config.fail("times_s", "must ascend");
}

void ExtractionPictures::take(const ExtractionFrame& frame, const FeatureMapSettings& settings) {
  if (next_ == times_s_.size()) return;
  if (!first_) first_ = frame.stamp;
  const double elapsed_s = to_seconds(frame.stamp - *first_);
  for (; next_ < times_s_.size() && elapsed_s >= times_s_[next_]; ++next_) {
    const double due_s = times_s_[next_];
    create_folder(folder_);
    write_file(folder_ / fmt::format("scan_{:g}s.png", due_s),
               draw_extraction(frame.view, frame.candidates, settings.extraction,
                               fmt::format("scan {:.2f} s after the first", elapsed_s)));
    if (frame.look == nullptr || frame.look->image.bgr.empty() || !settings.camera) continue;
    write_file(folder_ / fmt::format("camera_{:g}s.png", due_s),
               draw_look(frame.view, frame.T_base_scanner, frame.candidates, *frame.look, *settings.camera,
                         fmt::format("image of the scan {:.2f} s after the first", elapsed_s)));
  }
}

}  // namespace waymark::feature_map
