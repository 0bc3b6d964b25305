// SPDX-License-Identifier: Apache-2.0
#include "picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "framing.hpp"
#include "sheet.hpp"
#include "waymark/interface/pose_modes.hpp"

namespace waymark::plot {
namespace {

constexpr std::size_t kMostLabels = 60;    // more make the map unreadable, so `auto` drops them
constexpr double kSmallestLandmark = 3.0;  // [px]
constexpr double kSmallestEllipse = 4.0;   // [px]

void draw_dense_maps(Sheet& sheet) {
  if (!sheet.content.end) return;
  std::array<Color, 256> colors;
  colors.fill(kWhite);  // unknown
  const auto shade = [](int free, int occupied, int percent) { return free + (occupied - free) * percent / 100; };
  for (int p = 0; p <= 100; ++p) {
    colors[static_cast<std::size_t>(p)] = {shade(kFreeCell.red, kOccupiedCell.red, p),
                                           shade(kFreeCell.green, kOccupiedCell.green, p),
                                           shade(kFreeCell.blue, kOccupiedCell.blue, p)};
  }
  if (sheet.style.disagreement) std::fill(colors.begin() + 1, colors.begin() + 100, kDisputedCell);
  for (const MapDescription& map : sheet.content.end->maps) {
    const auto& shown = sheet.style.disagreement ? map.mixture : map.grid;
    if (shown) sheet.canvas.cells(sheet.view, *shown, colors);
  }
}

std::size_t count_inside(const Sheet& sheet, const Points& pixels) {
  return static_cast<std::size_t>(
      std::ranges::count_if(pixels, [&](const Eigen::Vector2d& p) { return sheet.view.area().contains(p); }));
}

/// In pixels; 0 for one that is not drawn.
double longer_half_axis(const Eigen::Vector2d& centre, const Points& outline) {
  double most = 0.0;
  for (const Eigen::Vector2d& p : outline) most = std::max(most, (p - centre).norm());
  return most;
}

void draw_gnss(Sheet& sheet) {
  const double radius = sheet.px(sheet.style.window ? 4.0 : 2.0);  // a part has few of them
  const auto draw_all = [&](const Points& fixes, Color color, std::size_t& seen) {
    for (const auto& fix : fixes) {
      const Eigen::Vector2d at = sheet.view.to_pixel(fix);
      if (!sheet.view.area().contains(at)) continue;
      sheet.canvas.dot(at, radius, color);
      ++seen;
    }
  };
  draw_all(sheet.content.gnss_held_out, kHeldOut, sheet.seen.held_out);
  draw_all(sheet.content.gnss_fused, kFused, sheet.seen.fused);
  draw_all(sheet.content.gnss_rejected, kRejected, sheet.seen.rejected);
}

void draw_reference_trajectory(Sheet& sheet) {
  if (sheet.content.reference == nullptr) return;
  const auto& trajectory = sheet.content.reference->trajectory;
  // A pause of the reference is not a straight drive, so the line breaks there.
  std::vector<double> steps;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    steps.push_back(to_seconds(trajectory[i].stamp - trajectory[i - 1].stamp));
  double pause = std::numeric_limits<double>::infinity();
  if (!steps.empty()) {
    std::vector<double> sorted = steps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    pause = std::max(2.0, 10.0 * sorted[sorted.size() / 2]);
  }
  Points line;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0 && steps[i - 1] > pause)
      line.push_back(Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
    line.push_back(sheet.view.to_pixel(planar(trajectory[i].T_map_base)));
  }
  sheet.canvas.polyline(line, sheet.px(2.5), kReference);
  sheet.seen.reference = count_inside(sheet, line);
}

void draw_trajectories(Sheet& sheet) {
  Points online;
  for (const auto& p : sheet.content.online) online.push_back(sheet.view.to_pixel(p));
  sheet.canvas.polyline(online, sheet.px(3.5), kEstimate);
  sheet.seen.online = count_inside(sheet, online);
  if (!sheet.content.end) return;
  Points path;
  for (const auto& node : sheet.content.end->best_path) path.push_back(sheet.view.to_pixel(planar(node.T_map_base)));
  sheet.canvas.polyline(path, sheet.px(0.7), kBestPath);
  sheet.seen.path = count_inside(sheet, path);
}

void draw_uncertainty(Sheet& sheet) {
  if (!sheet.style.ellipses) return;
  // Not more than can be told apart, and none that the line hides.
  struct Drawn {
    Eigen::Vector2d centre;
    double size;
  };
  std::vector<Drawn> drawn;
  for (const auto& belief : sheet.content.uncertainty) {
    const Eigen::Vector2d centre = sheet.view.to_pixel(belief.position);
    if (!sheet.view.area().contains(centre)) continue;
    const Points outline = ellipse(sheet.view, belief.position, belief.P, sheet.style.sigma);
    const double size = longer_half_axis(centre, outline);
    if (size < sheet.px(kSmallestEllipse)) continue;
    const bool is_free = std::ranges::all_of(
        drawn, [&](const Drawn& other) { return (centre - other.centre).norm() > 1.1 * (size + other.size); });
    if (!is_free) continue;
    drawn.push_back({centre, size});
    sheet.canvas.outline(outline, sheet.px(1.0), kUncertainty);
  }
  sheet.seen.uncertainty = drawn.size();
}

double landmark_radius(const Sheet& sheet, double radius_m) {
  const double true_size = std::isfinite(radius_m) ? radius_m * sheet.view.pixels_per_metre() : 0.0;
  return std::max(sheet.px(kSmallestLandmark), true_size);
}

void draw_landmarks(Sheet& sheet) {
  const auto is_seen = [&](const LandmarkView& landmark) {
    return sheet.view.area().contains(sheet.view.to_pixel(landmark.p_map)) ? 1 : 0;
  };
  sheet.for_each_landmark(false, [&](const LandmarkView& landmark) {
    sheet.seen.provisional += is_seen(landmark);
    sheet.canvas.ring(sheet.view.to_pixel(landmark.p_map), landmark_radius(sheet, landmark.radius_m), sheet.px(1.5),
                      kProvisional);
  });
  sheet.for_each_landmark(true, [&](const LandmarkView& landmark) {
    const Points outline = ellipse(sheet.view, landmark.p_map, landmark.P.topLeftCorner<2, 2>(), sheet.style.sigma);
    sheet.canvas.outline(outline, sheet.px(1.3), kLandmarkEllipse);
    const double size = longer_half_axis(sheet.view.to_pixel(landmark.p_map), outline);
    // A smaller one is below the landmark.
    if (size > landmark_radius(sheet, landmark.radius_m)) sheet.seen.landmark_ellipses += is_seen(landmark);
    sheet.seen.landmarks += is_seen(landmark);
  });
  sheet.for_each_landmark(true, [&](const LandmarkView& landmark) {
    sheet.canvas.dot(sheet.view.to_pixel(landmark.p_map), landmark_radius(sheet, landmark.radius_m), kLandmark);
  });
}

void draw_reference_landmarks(Sheet& sheet) {
  if (sheet.content.reference == nullptr) return;
  for (const auto& landmark : sheet.content.reference->landmarks) {
    const Eigen::Vector2d at = sheet.view.to_pixel(landmark.p_map);
    sheet.seen.surveyed += sheet.view.area().contains(at) ? 1 : 0;
    const double radius = landmark.radius_m * sheet.view.pixels_per_metre();
    if (radius > sheet.px(kSmallestLandmark)) sheet.canvas.ring(at, radius, sheet.px(1.3), kReference);
    sheet.canvas.cross(at, sheet.px(6), sheet.px(1.5), kReference);
  }
}

/// Where the particles have the robot at several places, an arrow at each, with its share of their weight.
void draw_modes(Sheet& sheet) {
  ModeFinder finder;
  const std::vector<PoseMode>& modes = finder.find(sheet.content.end->particles);
  if (modes.size() < 2) return;
  for (const PoseMode& mode : modes) {
    const Eigen::Vector2d at = sheet.view.to_pixel(planar(mode.T_map_base));
    sheet.canvas.polygon(arrow(at, mode.T_map_base.yaw(), sheet.px(10.5)), kParticle);
    sheet.canvas.text(at + Eigen::Vector2d(sheet.px(9), -sheet.px(6)), fmt::format("{:.0f} %", 100.0 * mode.weight),
                      sheet.px(10), kInk, sheet.px(1));
    sheet.seen.modes += sheet.view.area().contains(at) ? 1 : 0;
  }
}

void draw_robot(Sheet& sheet) {
  if (!sheet.content.end) return;
  const Pose& pose = sheet.content.end->T_map_base;
  const Eigen::Vector2d at = sheet.view.to_pixel(planar(pose));
  const double size = sheet.px(13);
  if (sheet.content.end->particles.size() > 1) {
    for (const auto& particle : sheet.content.end->particles) {
      const Eigen::Vector2d place = sheet.view.to_pixel(planar(particle.T_map_base));
      sheet.canvas.dot(place, sheet.px(1.8), kParticle);
      if (sheet.view.area().contains(place) && (place - at).norm() > 0.6 * size) ++sheet.seen.particles;
    }
  }
  draw_modes(sheet);
  const Points outline =
      ellipse(sheet.view, planar(pose), sheet.content.end->P.topLeftCorner<2, 2>(), sheet.style.sigma);
  sheet.canvas.outline(outline, sheet.px(1.5), kRobot);
  sheet.seen.robot = sheet.view.area().contains(at) ? 1 : 0;
  if (sheet.seen.robot > 0 && longer_half_axis(at, outline) > 0.6 * size) sheet.seen.robot_ellipse = 1;
  sheet.canvas.polygon(arrow(at, pose.yaw(), sheet.px(13)), kWhite);
  sheet.canvas.polygon(arrow(at, pose.yaw(), sheet.px(10.5)), kRobot);
}

void draw_labels(Sheet& sheet) {
  std::size_t count = 0;
  sheet.for_each_landmark(true, [&](const LandmarkView&) { ++count; });
  const bool automatic = sheet.style.landmark_labels == Style::Labels::automatic;
  if (sheet.style.landmark_labels == Style::Labels::off || (automatic && count > kMostLabels)) return;
  std::vector<Rect> taken;
  sheet.for_each_landmark(true, [&](const LandmarkView& landmark) {
    const Eigen::Vector2d at = sheet.view.to_pixel(landmark.p_map);
    const double r = landmark_radius(sheet, landmark.radius_m);
    taken.push_back({at.x() - r, at.y() - r, at.x() + r, at.y() + r});
  });
  const double size = sheet.px(8.5);
  sheet.for_each_landmark(true, [&](const LandmarkView& landmark) {
    const std::string words = fmt::format("{}", landmark.id);
    const Eigen::Vector2d at = sheet.view.to_pixel(landmark.p_map);
    // Beside the ellipse as well, unless that is so large that the number would lose its landmark.
    const double spread =
        sheet.style.sigma * std::sqrt(std::max(0.0, landmark.P(0, 0))) * sheet.view.pixels_per_metre();
    const double radius = landmark_radius(sheet, landmark.radius_m);
    const double away = sheet.px(4) + std::max(radius, std::min(spread, sheet.px(30)));
    const double width = sheet.canvas.text_width(words, size);
    const std::array<Eigen::Vector2d, 4> places{Eigen::Vector2d(at.x() + away, at.y() + 0.5 * size),
                                                Eigen::Vector2d(at.x() - away - width, at.y() + 0.5 * size),
                                                Eigen::Vector2d(at.x() - 0.5 * width, at.y() - away),
                                                Eigen::Vector2d(at.x() - 0.5 * width, at.y() + away + size)};
    for (const Eigen::Vector2d& place : places) {
      const Rect box{place.x() - sheet.px(1), place.y() - size - sheet.px(1), place.x() + width + sheet.px(1),
                     place.y() + sheet.px(1)};
      const bool free =
          std::none_of(taken.begin(), taken.end(), [&](const Rect& other) { return other.overlaps(box); });
      if (!free && automatic) continue;
      taken.push_back(box);
      sheet.canvas.text(place, words, size, kInk, sheet.px(1));
      break;
    }
  });
}

void draw_no_data(Sheet& sheet) {
  const Rect& area = sheet.view.area();
  const Eigen::Vector2d centre(0.5 * (area.left + area.right), 0.5 * (area.top + area.bottom));
  const std::string words = "no data";
  const std::string reason = "the filter did not start";
  const double width =
      std::max(sheet.canvas.text_width(words, sheet.px(30)), sheet.canvas.text_width(reason, sheet.px(14)));
  sheet.canvas.box({centre.x() - 0.5 * width - sheet.px(24), centre.y() - sheet.px(46),
                    centre.x() + 0.5 * width + sheet.px(24), centre.y() + sheet.px(56)},
                   kWhite);
  sheet.canvas.text(centre - Eigen::Vector2d(0.5 * sheet.canvas.text_width(words, sheet.px(30)), 0.0), words,
                    sheet.px(30), kInk, sheet.px(2.5));
  sheet.canvas.text(centre + Eigen::Vector2d(-0.5 * sheet.canvas.text_width(reason, sheet.px(14)), sheet.px(38)),
                    reason, sheet.px(14), kSoftInk, sheet.px(1.2));
}

}  // namespace

std::string draw(const Content& content, const Style& style) {
  Sheet sheet(content, style);
  sheet.canvas.clip(sheet.view.area());
  // From the background to the foreground.
  draw_dense_maps(sheet);
  draw_grid(sheet);
  draw_gnss(sheet);
  draw_reference_trajectory(sheet);
  draw_trajectories(sheet);
  draw_uncertainty(sheet);
  draw_reference_landmarks(sheet);
  draw_landmarks(sheet);
  draw_robot(sheet);
  draw_labels(sheet);
  draw_scale_bar(sheet);
  if (!content.end) draw_no_data(sheet);
  sheet.canvas.no_clip();
  sheet.canvas.frame(sheet.view.area(), sheet.px(1), kFrame);
  draw_axis_labels(sheet);
  draw_title(sheet);
  draw_legend(sheet);
  return sheet.canvas.png();
}

}  // namespace waymark::plot
