// SPDX-License-Identifier: Apache-2.0
#include "canvas.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#ifdef WAYMARK_FONT
#include <opencv2/freetype.hpp>
#endif
#include <string>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::plot {
namespace {

// Everything is drawn twice as large and scaled down, so that text and thin lines get finer shades than OpenCV's own.
constexpr int kOversampling = 2;
constexpr int kShift = 4;  // fractional bits of OpenCV's fixed-point coordinates
constexpr double kLargestCoordinate = 1e5;
constexpr int kStrokeFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kStrokeFontCapitals = 21.0;  // height of capitals at scale 1

cv::Scalar scalar(Color c) { return cv::Scalar(c.blue, c.green, c.red); }

int pen(double width) { return std::max(1, static_cast<int>(std::lround(width * kOversampling))); }

bool drawable(const Eigen::Vector2d& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() < kLargestCoordinate; }

std::vector<Eigen::Vector2d> circle(const Eigen::Vector2d& centre, double radius) {
  const int corners = std::clamp(static_cast<int>(4.0 * std::sqrt(radius)) * 4, 16, 180);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    points.emplace_back(centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

/// What the stroke font can draw.
std::string in_ascii(std::string_view words) {
  std::string text(words);
  for (const auto& [from, to] :
       {std::pair<std::string_view, std::string_view>{"±", "+-"}, {"σ", " sigma"}, {"°", " deg"}}) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  }
  return text;
}

}  // namespace

#ifdef WAYMARK_FONT
/// A font that is read from a file.
class Canvas::Font {
 public:
  /// Null if the file is not there any more, or cannot be read.
  static std::shared_ptr<const Font> load() {
    try {
      const auto renderer = cv::freetype::createFreeType2();
      renderer->loadFontData(WAYMARK_FONT, 0);
      return std::make_shared<const Font>(renderer);
    } catch (const cv::Exception&) {
      return nullptr;
    }
  }
  explicit Font(cv::Ptr<cv::freetype::FreeType2> renderer) : renderer_(std::move(renderer)) {}

  void draw(cv::Mat& image, const std::string& words, const cv::Point& base, double capitals,
            const cv::Scalar& color) const {
    renderer_->putText(image, words, base, size(capitals), color, -1, cv::LINE_AA, true);
  }
  double width(const std::string& words, double capitals) const {
    int base = 0;
    return renderer_->getTextSize(words, size(capitals), -1, &base).width;
  }

 private:
  /// Capitals of DejaVu Sans are 0.729 of the em.
  static int size(double capitals) { return std::max(1, static_cast<int>(std::lround(capitals / 0.729))); }

  cv::Ptr<cv::freetype::FreeType2> renderer_;
};
#else
class Canvas::Font {
 public:
  static std::shared_ptr<const Font> load() { return nullptr; }
  void draw(cv::Mat&, const std::string&, const cv::Point&, double, const cv::Scalar&) const {}
  double width(const std::string&, double) const { return 0.0; }
};
#endif

View::View(const Rect& area, Eigen::Vector2d low, Eigen::Vector2d high) : area_(area), centre_(0.5 * (low + high)) {
  const Eigen::Vector2d size = (high - low).cwiseMax(2.0);
  scale_ = std::min(area.width() / size.x(), area.height() / size.y());
}

Eigen::Vector2d View::to_pixel(const Eigen::Vector2d& world) const {
  const Eigen::Vector2d d = scale_ * (world - centre_);
  return {0.5 * (area_.left + area_.right) + d.x(), 0.5 * (area_.top + area_.bottom) - d.y()};
}

Eigen::Vector2d View::low() const { return centre_ - Eigen::Vector2d(area_.width(), area_.height()) / (2.0 * scale_); }

Eigen::Vector2d View::high() const { return centre_ + Eigen::Vector2d(area_.width(), area_.height()) / (2.0 * scale_); }

Canvas::Canvas(int width, int height)
    : width_(width),
      height_(height),
      font_(Font::load()),
      image_(height * kOversampling, width * kOversampling, CV_8UC3, cv::Scalar::all(255)) {
  no_clip();
}

void Canvas::clip(const Rect& area) {
  const auto edge = [](double v) { return static_cast<int>(std::lround(v * kOversampling)); };
  clip_ = cv::Rect(cv::Point(edge(area.left), edge(area.top)), cv::Point(edge(area.right), edge(area.bottom))) &
          cv::Rect(0, 0, image_.cols, image_.rows);
}

void Canvas::no_clip() { clip_ = cv::Rect(0, 0, image_.cols, image_.rows); }

cv::Mat Canvas::target() { return image_(clip_); }

cv::Point Canvas::fixed(const Eigen::Vector2d& p) const {
  // OpenCV's coordinates count from the centre of a pixel.
  constexpr double kFactor = kOversampling * (1 << kShift);
  constexpr int kHalf = 1 << (kShift - 1);
  return {static_cast<int>(std::lround(p.x() * kFactor)) - kHalf - clip_.x * (1 << kShift),
          static_cast<int>(std::lround(p.y() * kFactor)) - kHalf - clip_.y * (1 << kShift)};
}

std::vector<cv::Point> Canvas::fixed(std::span<const Eigen::Vector2d> points) const {
  std::vector<cv::Point> out;
  for (const Eigen::Vector2d& p : points) out.push_back(fixed(p));
  return out;
}

void Canvas::line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width, Color color) {
  if (!drawable(a) || !drawable(b)) return;
  cv::line(target(), fixed(a), fixed(b), scalar(color), pen(width), cv::LINE_AA, kShift);
}

void Canvas::polyline(std::span<const Eigen::Vector2d> points, double width, Color color) {
  // Points closer than half a pixel add nothing but time.
  constexpr double kNear = 0.5;
  std::vector<Eigen::Vector2d> piece;
  const auto flush = [&] {
    if (piece.size() > 1) {
      const std::vector<std::vector<cv::Point>> lines{fixed(piece)};
      cv::polylines(target(), lines, false, scalar(color), pen(width), cv::LINE_AA, kShift);
    }
    piece.clear();
  };
  for (const Eigen::Vector2d& p : points) {
    if (!drawable(p)) {
      flush();
    } else if (piece.empty() || (p - piece.back()).norm() >= kNear) {
      piece.push_back(p);
    }
  }
  flush();
}

void Canvas::polygon(std::span<const Eigen::Vector2d> points, Color fill) {
  if (points.empty() || !std::all_of(points.begin(), points.end(), drawable)) return;
  const std::vector<std::vector<cv::Point>> polygons{fixed(points)};
  cv::fillPoly(target(), polygons, scalar(fill), cv::LINE_AA, kShift);
}

void Canvas::outline(std::span<const Eigen::Vector2d> points, double width, Color color) {
  if (points.empty() || !std::all_of(points.begin(), points.end(), drawable)) return;
  const std::vector<std::vector<cv::Point>> polygons{fixed(points)};
  cv::polylines(target(), polygons, true, scalar(color), pen(width), cv::LINE_AA, kShift);
}

void Canvas::dot(const Eigen::Vector2d& centre, double radius, Color fill) { polygon(circle(centre, radius), fill); }

void Canvas::ring(const Eigen::Vector2d& centre, double radius, double width, Color color) {
  outline(circle(centre, radius), width, color);
}

void Canvas::cross(const Eigen::Vector2d& centre, double half_size, double width, Color color) {
  const Eigen::Vector2d up(half_size, -half_size);
  const Eigen::Vector2d down(half_size, half_size);
  line(centre - up, centre + up, width, color);
  line(centre - down, centre + down, width, color);
}

void Canvas::box(const Rect& area, Color fill) {
  polygon(
      std::vector<Eigen::Vector2d>{
          {area.left, area.top}, {area.right, area.top}, {area.right, area.bottom}, {area.left, area.bottom}},
      fill);
}

void Canvas::frame(const Rect& area, double width, Color color) {
  outline(
      std::vector<Eigen::Vector2d>{
          {area.left, area.top}, {area.right, area.top}, {area.right, area.bottom}, {area.left, area.bottom}},
      width, color);
}

void Canvas::cells(const View& view, const GridView& grid, const std::array<Color, 256>& colors) {
  if (grid.width <= 0 || grid.height <= 0) return;
  cv::Mat image(grid.height, grid.width, CV_8UC3);
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const auto place = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width);
      const Color c = colors[grid.cells[place + static_cast<std::size_t>(column)]];
      image.at<cv::Vec3b>(row, column) = {static_cast<uchar>(c.blue), static_cast<uchar>(c.green),
                                          static_cast<uchar>(c.red)};
    }
  }
  Eigen::Vector2d cell(grid.resolution_m, grid.resolution_m);
  const double pixels = grid.resolution_m * view.pixels_per_metre() * kOversampling;
  if (pixels < 1.0) {
    // A grid far from all the rest may be less than a pixel.
    const cv::Size size(std::max(cvRound(grid.width * pixels), 1), std::max(cvRound(grid.height * pixels), 1));
    cv::resize(image, image, size, 0.0, 0.0, cv::INTER_AREA);
    cell = {grid.resolution_m * grid.width / image.cols, grid.resolution_m * grid.height / image.rows};
  }
  // From the middles of cells to the middles of the picture's pixels, both counted from 0.
  const auto pixel_of = [&](double x, double y) {
    const Eigen::Vector3d p = grid.T_map_grid * Eigen::Vector3d(x * cell.x(), y * cell.y(), 0.0);
    return Eigen::Vector2d(kOversampling * view.to_pixel(p.head<2>()) - Eigen::Vector2d(clip_.x + 0.5, clip_.y + 0.5));
  };
  const Eigen::Vector2d zero = pixel_of(0.5, 0.5);
  const Eigen::Vector2d along = pixel_of(1.5, 0.5) - zero;
  const Eigen::Vector2d up = pixel_of(0.5, 1.5) - zero;
  const cv::Mat affine = (cv::Mat_<double>(2, 3) << along.x(), up.x(), zero.x(), along.y(), up.y(), zero.y());
  cv::Mat area = target();
  cv::warpAffine(image, area, affine, area.size(), cv::INTER_NEAREST, cv::BORDER_TRANSPARENT);
}

void Canvas::text(const Eigen::Vector2d& origin, std::string_view words, double height, Color color, double width) {
  if (!drawable(origin)) return;
  const cv::Point at(static_cast<int>(std::lround(origin.x() * kOversampling)) - clip_.x,
                     static_cast<int>(std::lround(origin.y() * kOversampling)) - clip_.y);
  cv::Mat area = target();
  if (font_) {
    font_->draw(area, std::string(words), at, height * kOversampling, scalar(color));
    return;
  }
  cv::putText(area, in_ascii(words), at, kStrokeFont, height * kOversampling / kStrokeFontCapitals, scalar(color),
              pen(width), cv::LINE_AA);
}

double Canvas::text_width(std::string_view words, double height) const {
  if (font_) return font_->width(std::string(words), height * kOversampling) / kOversampling;
  int base = 0;
  const cv::Size size =
      cv::getTextSize(in_ascii(words), kStrokeFont, height * kOversampling / kStrokeFontCapitals, pen(1.2), &base);
  return static_cast<double>(size.width) / kOversampling;
}

std::string Canvas::png() const {
  cv::Mat small;
  cv::resize(image_, small, cv::Size(width_, height_), 0.0, 0.0, cv::INTER_AREA);
  std::vector<uchar> bytes;
  bool done = false;
  try {
    done = cv::imencode(".png", small, bytes, {cv::IMWRITE_PNG_COMPRESSION, 6});
  } catch (const cv::Exception& e) {
    throw Error(std::string("plot: the picture cannot be encoded as PNG: ") + e.what());
  }
  if (!done) throw Error("plot: the picture cannot be encoded as PNG");
  return {bytes.begin(), bytes.end()};
}

std::vector<Eigen::Vector2d> ellipse(const View& view, const Eigen::Vector2d& centre, const Eigen::Matrix2d& P,
                                     double sigma) {
  if (!centre.allFinite() || !P.allFinite()) return {};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(P);
  const Eigen::Vector2d half = sigma * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  if (!(half.maxCoeff() * view.pixels_per_metre() < 0.5 * kLargestCoordinate)) return {};
  constexpr int kCorners = 72;
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kCorners;
    const Eigen::Vector2d along(half.x() * std::cos(angle), half.y() * std::sin(angle));
    points.push_back(view.to_pixel(centre + axes.eigenvectors() * along));
  }
  return points;
}

}  // namespace waymark::plot
