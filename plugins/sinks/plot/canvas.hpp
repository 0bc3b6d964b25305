// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/interface/map_view.hpp"

namespace waymark::plot {

/// Colour, 0..255 each.
struct Color {
  int red;
  int green;
  int blue;
};

/// A rectangle of the picture [px], y downwards.
struct Rect {
  double left;
  double top;
  double right;
  double bottom;

  double width() const { return right - left; }
  double height() const { return bottom - top; }
  bool contains(const Eigen::Vector2d& p) const {
    return p.x() >= left && p.x() <= right && p.y() >= top && p.y() <= bottom;
  }
  bool overlaps(const Rect& o) const { return left < o.right && o.left < right && top < o.bottom && o.top < bottom; }
};

/// The equal-axis map from world (east, north [m]) to picture (right, down [px]) that fits an extent into a rectangle.
class View {
 public:
  /// Shows at least the box `low`..`high`, centred; a box without area gets a few metres.
  View(const Rect& area, Eigen::Vector2d low, Eigen::Vector2d high);

  Eigen::Vector2d to_pixel(const Eigen::Vector2d& world) const;
  double pixels_per_metre() const { return scale_; }
  const Rect& area() const { return area_; }
  /// The world's box that the rectangle shows.
  Eigen::Vector2d low() const;
  Eigen::Vector2d high() const;

 private:
  Rect area_;
  Eigen::Vector2d centre_;
  double scale_;
};

/// A white picture with anti-aliased primitives. All coordinates and sizes in pixels, with fractions. What leaves the
/// clip rectangle is not drawn.
class Canvas {
 public:
  Canvas(int width, int height);

  void clip(const Rect& area);
  void no_clip();

  void line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width, Color color);
  /// Points that are not finite break the line.
  void polyline(std::span<const Eigen::Vector2d> points, double width, Color color);
  void polygon(std::span<const Eigen::Vector2d> points, Color fill);
  void outline(std::span<const Eigen::Vector2d> points, double width, Color color);
  void dot(const Eigen::Vector2d& centre, double radius, Color fill);
  void ring(const Eigen::Vector2d& centre, double radius, double width, Color color);
  void cross(const Eigen::Vector2d& centre, double half_size, double width, Color color);
  void box(const Rect& area, Color fill);
  void frame(const Rect& area, double width, Color color);
  /// Text with its left end and base line at `origin`, capitals `height` high. ASCII only.
  void text(const Eigen::Vector2d& origin, std::string_view words, double height, Color color, double width = 1.2);
  static double text_width(std::string_view words, double height);

  /// A grid of cells, each in the colour of its value. Cells smaller than a pixel are averaged.
  void cells(const View& view, const GridView& grid, const std::array<Color, 256>& colors);

  int width() const { return width_; }
  int height() const { return height_; }
  /// The picture as a PNG file. Throws Error if it cannot be encoded.
  std::string png() const;

 private:
  cv::Mat target();
  cv::Point fixed(const Eigen::Vector2d& p) const;
  std::vector<cv::Point> fixed(std::span<const Eigen::Vector2d> points) const;

  int width_;
  int height_;
  cv::Mat image_;
  cv::Rect clip_;
};

/// The ellipse of `sigma` standard deviations of a 2 × 2 covariance [m²] around a point, in pixels; empty if the
/// covariance is not finite or the ellipse is far larger than any picture.
std::vector<Eigen::Vector2d> ellipse(const View& view, const Eigen::Vector2d& centre, const Eigen::Matrix2d& P,
                                     double sigma);

}  // namespace waymark::plot
