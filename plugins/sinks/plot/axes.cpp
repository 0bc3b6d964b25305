// SPDX-License-Identifier: Apache-2.0
// Grid, axes, scale bar and title.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "framing.hpp"
#include "plugins/shared/run_views/titles.hpp"
#include "sheet.hpp"

namespace waymark::plot {
namespace {

double grid_step(const Sheet& sheet) { return round_step(sheet.px(90) / sheet.view.pixels_per_metre()); }

/// Visits where a line is and the number that stands there.
template <class Visit>
void for_each_grid_line(const Sheet& sheet, int axis, Visit visit) {
  const double step = grid_step(sheet);
  const double origin = sheet.content.axes.origin[axis];
  const auto first = static_cast<long long>(std::ceil((sheet.view.low()[axis] + origin) / step));
  const auto last = static_cast<long long>(std::floor((sheet.view.high()[axis] + origin) / step));
  for (long long k = first; k <= last; ++k) {
    const double number = static_cast<double>(k) * step;
    visit(number - origin, number);
  }
}

}  // namespace

void draw_grid(Sheet& sheet) {
  const Rect& area = sheet.view.area();
  for_each_grid_line(sheet, 0, [&](double east, double) {
    const double x = sheet.view.to_pixel({east, 0.0}).x();
    sheet.canvas.line({x, area.top}, {x, area.bottom}, sheet.px(1), kGrid);
  });
  for_each_grid_line(sheet, 1, [&](double north, double) {
    const double y = sheet.view.to_pixel({0.0, north}).y();
    sheet.canvas.line({area.left, y}, {area.right, y}, sheet.px(1), kGrid);
  });
}

void draw_axis_labels(Sheet& sheet) {
  const Rect& area = sheet.view.area();
  const double size = sheet.px(10);
  for_each_grid_line(sheet, 0, [&](double east, double number) {
    const double x = sheet.view.to_pixel({east, 0.0}).x();
    const std::string words = fmt::format("{:.10g}", number);
    sheet.canvas.line({x, area.bottom}, {x, area.bottom + sheet.px(5)}, sheet.px(1), kFrame);
    sheet.canvas.text({x - 0.5 * sheet.canvas.text_width(words, size), area.bottom + sheet.px(20)}, words, size,
                      kSoftInk, sheet.px(1));
  });
  for_each_grid_line(sheet, 1, [&](double north, double number) {
    const double y = sheet.view.to_pixel({0.0, north}).y();
    const std::string words = fmt::format("{:.10g}", number);
    sheet.canvas.line({area.left - sheet.px(5), y}, {area.left, y}, sheet.px(1), kFrame);
    sheet.canvas.text({area.left - sheet.px(10) - sheet.canvas.text_width(words, size), y + 0.5 * size}, words, size,
                      kSoftInk, sheet.px(1));
  });
  const double middle = 0.5 * (area.left + area.right);
  const std::string& east = sheet.content.axes.east;
  sheet.canvas.text({middle - 0.5 * sheet.canvas.text_width(east, sheet.px(11)), area.bottom + sheet.px(44)}, east,
                    sheet.px(11), kInk, sheet.px(1));
  sheet.canvas.text({sheet.px(12), area.top - sheet.px(12)}, sheet.content.axes.north, sheet.px(11), kInk, sheet.px(1));
}

void draw_scale_bar(Sheet& sheet) {
  const Rect& area = sheet.view.area();
  const double metres = round_step(sheet.px(110) / sheet.view.pixels_per_metre());
  const double length = metres * sheet.view.pixels_per_metre();
  const std::string words = metres >= 1000.0 ? fmt::format("{:g} km", 1e-3 * metres) : fmt::format("{:g} m", metres);
  const double left = area.left + sheet.px(22);
  const double y = area.bottom - sheet.px(22);
  sheet.canvas.box({left - sheet.px(10), y - sheet.px(30), left + length + sheet.px(10), y + sheet.px(12)}, kWhite);
  sheet.canvas.line({left, y}, {left + length, y}, sheet.px(2), kInk);
  for (const double x : {left, left + length})
    sheet.canvas.line({x, y - sheet.px(5)}, {x, y + sheet.px(5)}, sheet.px(2), kInk);
  sheet.canvas.text({left + 0.5 * (length - sheet.canvas.text_width(words, sheet.px(11))), y - sheet.px(11)}, words,
                    sheet.px(11), kInk, sheet.px(1.2));
}

void draw_title(Sheet& sheet) {
  std::vector<std::string> parts;
  if (!sheet.content.name.empty()) parts.push_back(sheet.content.name);
  if (const std::string date = run_views::date_text(sheet.content.log_start); !date.empty()) parts.push_back(date);
  parts.push_back(run_views::duration_text(sheet.content.log_duration_s) + " of log");
  if (sheet.content.end) {
    const std::size_t particles = sheet.content.end->particles.size();
    if (particles > 0) parts.push_back(fmt::format("{} particle{}", particles, particles == 1 ? "" : "s"));
    if (std::ranges::any_of(sheet.content.end->maps, [](const MapDescription& map) { return !map.grid; })) {
      std::size_t confirmed = 0;
      sheet.for_each_landmark(true, [&](const LandmarkView&) { ++confirmed; });
      parts.push_back(fmt::format("{} landmark{}", confirmed, confirmed == 1 ? "" : "s"));
    }
  }
  if (sheet.content.interrupted) parts.emplace_back("interrupted");
  const std::string words = fmt::format("{}", fmt::join(parts, "  |  "));
  const double middle = 0.5 * (sheet.view.area().left + sheet.view.area().right);
  sheet.canvas.text({middle - 0.5 * sheet.canvas.text_width(words, sheet.px(15)), sheet.px(38)}, words, sheet.px(15),
                    kInk, sheet.px(1.6));
}

}  // namespace waymark::plot
