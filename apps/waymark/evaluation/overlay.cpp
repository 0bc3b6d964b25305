// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/overlay.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "apps/waymark/evaluation/nice_step.hpp"
#include "waymark/io/xml_text.hpp"

namespace waymark::evaluation {
namespace {

constexpr double kSide = 900.0;           // the longer side of the paths [px]
constexpr double kMargin = 60.0;          // [px]
constexpr double kSmallestPixels = 0.75;  // points that are nearer to each other show nothing more
constexpr std::array<std::string_view, 8> kColours{"#1f77b4", "#d62728", "#2ca02c", "#9467bd",
                                                   "#ff7f0e", "#17becf", "#8c564b", "#e377c2"};

/// From the map to the drawing.
class Frame {
 public:
  explicit Frame(const std::vector<OverlayPath>& paths) {
    Eigen::AlignedBox2d box;
    for (const OverlayPath& path : paths) {
      for (const Eigen::Vector2d& point : path.points) box.extend(point);
    }
    if (box.isEmpty()) box.extend(Eigen::Vector2d::Zero());
    constexpr double kLeast = 1.0;  // [m]
    const double side = std::max(box.sizes().maxCoeff(), kLeast);
    const Eigen::Vector2d edge = Eigen::Vector2d::Constant(0.05 * side);
    box_ = {box.min() - edge, box.max() + edge};
    step_ = nice_step(side);
    scale_ = kSide / side;
  }
  double width() const { return scale_ * box_.sizes().x() + 2.0 * kMargin; }
  double height() const { return scale_ * box_.sizes().y() + 2.0 * kMargin; }
  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    return {kMargin + scale_ * (p.x() - box_.min().x()), kMargin + scale_ * (box_.max().y() - p.y())};
  }
  double step() const { return step_; }

  std::string grid() const {
    std::string out = "<g stroke=\"#ddd\" fill=\"#555\" font-size=\"12\">\n";
    const Eigen::Vector2d low = box_.min();
    const Eigen::Vector2d high = box_.max();
    for (double x = step_ * std::ceil(low.x() / step_); x <= high.x(); x += step_) {
      const Eigen::Vector2d at = (*this)({x, low.y()});
      out += fmt::format(
          "<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text stroke=\"none\" x=\"{0:.1f}\" y=\"{3:.1f}\" "
          "text-anchor=\"middle\">{4:g}</text>\n",
          at.x(), at.y(), kMargin, at.y() + 16.0, x);
    }
    for (double y = step_ * std::ceil(low.y() / step_); y <= high.y(); y += step_) {
      const Eigen::Vector2d at = (*this)({low.x(), y});
      out += fmt::format(
          "<path d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text stroke=\"none\" x=\"{3:.1f}\" y=\"{4:.1f}\" "
          "text-anchor=\"end\">{5:g}</text>\n",
          at.x(), at.y(), (*this)(high).x(), at.x() - 6.0, at.y() + 4.0, y);
    }
    return out + "</g>\n";
  }

 private:
  Eigen::AlignedBox2d box_;
  double step_ = 1.0;
  double scale_ = 1.0;
};

std::string line_of(const OverlayPath& path, const Frame& frame, std::string_view colour) {
  std::string out = fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" points=\"", colour);
  Eigen::Vector2d last = Eigen::Vector2d::Constant(-kSide);
  for (const Eigen::Vector2d& point : path.points) {
    const Eigen::Vector2d at = frame(point);
    if ((at - last).norm() < kSmallestPixels) continue;
    out += fmt::format("{:.1f},{:.1f} ", at.x(), at.y());
    last = at;
  }
  return out + "\"/>\n";
}

}  // namespace

std::string overlay_svg(const std::vector<OverlayPath>& paths) {
  const Frame frame(paths);
  constexpr double kLine = 18.0;  // of the legend [px]
  const double legend = kLine * static_cast<double>(paths.size() + 1);
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      frame.width(), frame.height() + legend);
  out += frame.grid();
  std::string names;
  std::size_t colours = 0;
  double y = frame.height();
  for (const OverlayPath& path : paths) {
    const std::string_view colour = path.name == "reference" ? "black" : kColours[colours++ % kColours.size()];
    out += line_of(path, frame, colour);
    names += fmt::format(
        "<rect x=\"{0:.0f}\" y=\"{1:.0f}\" width=\"24\" height=\"4\" fill=\"{2}\"/><text x=\"{3:.0f}\" "
        "y=\"{4:.0f}\" font-size=\"14\">{5}</text>\n",
        kMargin, y, colour, kMargin + 32.0, y + 6.0, xml_text(path.name));
    y += kLine;
  }
  return out + names +
         fmt::format(
             "<text x=\"{:.0f}\" y=\"{:.0f}\" font-size=\"12\" fill=\"#555\">east and north [m], a line every "
             "{:g} m</text>\n</svg>\n",
             kMargin, y + 6.0, frame.step());
}

}  // namespace waymark::evaluation
