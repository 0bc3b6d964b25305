// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/strip_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "apps/waymark/evaluation/nice_step.hpp"
#include "waymark/io/xml_text.hpp"

namespace waymark::sweep {

namespace {

constexpr double kLeft = 260.0;  // for the names
constexpr double kWidth = 560.0;
constexpr double kRow = 26.0;
constexpr double kFoot = 34.0;

struct Axis {
  double low;
  double high;
  double at(double value) const { return kLeft + kWidth * (value - low) / (high - low); }
};

/// From zero on if the values are of one sign and not crowded far from it.
Axis axis_of(const Score& score, const Summary& summary, std::size_t index) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto include = [&](double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  };
  for (const Line& line : summary.lines) {
    for (const double value : line.cells[index].values) include(value);
  }
  if (!(low <= high)) return {0.0, 0.0};
  if (score.at_most) include(*score.at_most);
  if (score.at_least) include(*score.at_least);
  if (low > 0.0 && low < 0.7 * high) low = 0.0;
  if (low == high) return {low - 0.5, high + 0.5};
  const double margin = 0.03 * (high - low);
  return {low == 0.0 ? 0.0 : low - margin, high + margin};
}

std::string line(double x1, double y1, double x2, double y2, std::string_view style) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x1, y1, x2, y2, style);
}

}  // namespace

std::string strip_plot(const Score& score, const Summary& summary, std::size_t index) {
  const Axis axis = axis_of(score, summary, index);
  if (!(axis.low < axis.high)) return {};
  const double bottom = kRow * static_cast<double>(summary.lines.size());
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n",
      kLeft + kWidth + 20.0, bottom + kFoot);
  const double step = evaluation::nice_step(axis.high - axis.low);
  for (double tick = std::ceil(axis.low / step) * step; tick <= axis.high; tick += step) {
    svg += line(axis.at(tick), 0.0, axis.at(tick), bottom, "stroke=\"#ddd\"");
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" fill=\"#555\">{:g}</text>\n",
                       axis.at(tick), bottom + 16.0, std::abs(tick) < 1e-9 * step ? 0.0 : tick);
  }
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", kLeft + 0.5 * kWidth,
                     bottom + 31.0, xml_text(score.name));
  for (const std::optional<double>& mark : {score.at_most, score.at_least}) {
    if (mark) svg += line(axis.at(*mark), 0.0, axis.at(*mark), bottom, "stroke=\"#b00020\" stroke-dasharray=\"4 3\"");
  }
  for (std::size_t row = 0; row < summary.lines.size(); ++row) {
    const double y = kRow * (static_cast<double>(row) + 0.5);
    const Cell& cell = summary.lines[row].cells[index];
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", kLeft - 10.0, y + 4.0,
                       xml_text(summary.lines[row].name));
    for (const double value : cell.values)
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"#1f6feb\" fill-opacity=\"0.5\"/>\n",
                         axis.at(value), y);
    const double middle = cell.shows_mean ? cell.mean : cell.median;
    if (!cell.values.empty())
      svg += line(axis.at(middle), y - 9.0, axis.at(middle), y + 9.0, "stroke=\"#111\" stroke-width=\"2\"");
  }
  return svg + "</svg>\n";
}

}  // namespace waymark::sweep
