// SPDX-License-Identifier: Apache-2.0
#include "picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "canvas.hpp"
#include "framing.hpp"

namespace waymark::plot {
namespace {

constexpr Color kInk{45, 52, 60};
constexpr Color kSoftInk{125, 133, 142};
constexpr Color kGrid{234, 236, 239};
constexpr Color kFrame{190, 195, 201};
constexpr Color kWhite{255, 255, 255};
constexpr Color kEstimate{92, 164, 222};
constexpr Color kUncertainty{120, 152, 200};
constexpr Color kBestPath{20, 48, 98};
constexpr Color kReference{204, 78, 70};
constexpr Color kHeldOut{216, 164, 158};
constexpr Color kFused{140, 192, 138};
constexpr Color kLandmark{28, 128, 120};
constexpr Color kLandmarkEllipse{132, 190, 184};
constexpr Color kProvisional{172, 186, 190};
constexpr Color kFreeCell{244, 243, 238};
constexpr Color kDisputedCell{226, 88, 34};
constexpr Color kOccupiedCell{58, 60, 66};
constexpr Color kParticle{232, 150, 46};
constexpr Color kRobot{20, 48, 98};

constexpr std::size_t kMostLabels = 60;    // more make the map unreadable, so `auto` drops them
constexpr double kSmallestLandmark = 3.0;  // [px]

using Points = std::vector<Eigen::Vector2d>;

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{:.1f} s", seconds);
}

/// Draws one content; every step is one kind of thing, in the order from background to foreground.
class Painter {
 public:
  Painter(const Content& content, const Style& style)
      : content_(content),
        style_(style),
        unit_(std::clamp(std::min(style.width_px / 1600.0, style.height_px / 1200.0), 0.5, 6.0)),
        canvas_(style.width_px, style.height_px),
        view_(make_view(content, style,
                        {px(content.axes.origin.isZero() ? 78 : 112), px(72), style.width_px - px(330),
                         style.height_px - px(58)})) {}

  std::string paint() {
    canvas_.clip(view_.area());
    draw_dense_maps();
    draw_grid();
    draw_gnss();
    draw_reference_trajectory();
    draw_trajectories();
    draw_uncertainty();
    draw_reference_landmarks();
    draw_landmarks();
    draw_robot();
    draw_labels();
    draw_scale_bar();
    if (!content_.end) draw_no_data();
    canvas_.no_clip();
    canvas_.frame(view_.area(), px(1), kFrame);
    draw_axis_labels();
    draw_title();
    draw_panel();
    return canvas_.png();
  }

 private:
  double px(double at_standard_size) const { return unit_ * at_standard_size; }

  double grid_step() const { return round_step(px(90) / view_.pixels_per_metre()); }

  /// Visits where a line is and the number that stands there.
  template <class Visit>
  void for_each_grid_line(int axis, Visit visit) const {
    const double step = grid_step();
    const double origin = content_.axes.origin[axis];
    const auto first = static_cast<long long>(std::ceil((view_.low()[axis] + origin) / step));
    const auto last = static_cast<long long>(std::floor((view_.high()[axis] + origin) / step));
    for (long long k = first; k <= last; ++k) {
      const double number = static_cast<double>(k) * step;
      visit(number - origin, number);
    }
  }

  void draw_dense_maps() {
    if (!content_.end) return;
    std::array<Color, 256> colors;
    colors.fill(kWhite);  // unknown
    const auto shade = [](int free, int occupied, int percent) { return free + (occupied - free) * percent / 100; };
    for (int p = 0; p <= 100; ++p) {
      colors[static_cast<std::size_t>(p)] = {shade(kFreeCell.red, kOccupiedCell.red, p),
                                             shade(kFreeCell.green, kOccupiedCell.green, p),
                                             shade(kFreeCell.blue, kOccupiedCell.blue, p)};
    }
    if (style_.disagreement) std::fill(colors.begin() + 1, colors.begin() + 100, kDisputedCell);
    for (const MapDescription& map : content_.end->maps) {
      const auto& shown = style_.disagreement ? map.mixture : map.grid;
      if (shown) canvas_.cells(view_, *shown, colors);
    }
  }

  void draw_grid() {
    const Rect& area = view_.area();
    for_each_grid_line(0, [&](double east, double) {
      const double x = view_.to_pixel({east, 0.0}).x();
      canvas_.line({x, area.top}, {x, area.bottom}, px(1), kGrid);
    });
    for_each_grid_line(1, [&](double north, double) {
      const double y = view_.to_pixel({0.0, north}).y();
      canvas_.line({area.left, y}, {area.right, y}, px(1), kGrid);
    });
  }

  void draw_axis_labels() {
    const Rect& area = view_.area();
    const double size = px(10);
    for_each_grid_line(0, [&](double east, double number) {
      const double x = view_.to_pixel({east, 0.0}).x();
      const std::string words = fmt::format("{:.10g}", number);
      canvas_.line({x, area.bottom}, {x, area.bottom + px(5)}, px(1), kFrame);
      canvas_.text({x - 0.5 * Canvas::text_width(words, size), area.bottom + px(20)}, words, size, kSoftInk, px(1));
    });
    for_each_grid_line(1, [&](double north, double number) {
      const double y = view_.to_pixel({0.0, north}).y();
      const std::string words = fmt::format("{:.10g}", number);
      canvas_.line({area.left - px(5), y}, {area.left, y}, px(1), kFrame);
      canvas_.text({area.left - px(10) - Canvas::text_width(words, size), y + 0.5 * size}, words, size, kSoftInk,
                   px(1));
    });
    const double middle = 0.5 * (area.left + area.right);
    const std::string& east = content_.axes.east;
    canvas_.text({middle - 0.5 * Canvas::text_width(east, px(11)), area.bottom + px(44)}, east, px(11), kInk, px(1));
    canvas_.text({px(12), area.top - px(12)}, content_.axes.north, px(11), kInk, px(1));
  }

  void draw_gnss() {
    const double radius = px(style_.window ? 4.0 : 2.0);  // a part has few of them
    for (const auto& p : content_.gnss_held_out) canvas_.dot(view_.to_pixel(p), radius, kHeldOut);
    for (const auto& p : content_.gnss_fused) canvas_.dot(view_.to_pixel(p), radius, kFused);
  }

  void draw_reference_trajectory() {
    if (content_.reference == nullptr) return;
    const auto& trajectory = content_.reference->trajectory;
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
      line.push_back(view_.to_pixel(planar(trajectory[i].T_map_base)));
    }
    canvas_.polyline(line, px(2.5), kReference);
  }

  void draw_trajectories() {
    Points online;
    for (const auto& p : content_.online) online.push_back(view_.to_pixel(p));
    canvas_.polyline(online, px(3.5), kEstimate);
    if (!content_.end) return;
    Points path;
    for (const auto& node : content_.end->best_path) path.push_back(view_.to_pixel(planar(node.T_map_base)));
    canvas_.polyline(path, px(0.7), kBestPath);
  }

  void draw_uncertainty() {
    if (!style_.ellipses) return;
    for (const auto& belief : content_.uncertainty) {
      canvas_.outline(ellipse(view_, belief.position, belief.P, style_.sigma), px(1.0), kUncertainty);
    }
  }

  template <class Visit>
  void for_each_landmark(bool confirmed, Visit visit) const {
    if (!content_.end) return;
    for (const auto& map : content_.end->maps) {
      for (const auto& landmark : map.landmarks) {
        if (landmark.confirmed == confirmed) visit(landmark);
      }
    }
  }

  double landmark_radius(double radius_m) const {
    const double true_size = std::isfinite(radius_m) ? radius_m * view_.pixels_per_metre() : 0.0;
    return std::max(px(kSmallestLandmark), true_size);
  }

  void draw_landmarks() {
    for_each_landmark(false, [&](const LandmarkView& landmark) {
      canvas_.ring(view_.to_pixel(landmark.p_map), landmark_radius(landmark.radius_m), px(1.5), kProvisional);
    });
    for_each_landmark(true, [&](const LandmarkView& landmark) {
      canvas_.outline(ellipse(view_, landmark.p_map, landmark.P.topLeftCorner<2, 2>(), style_.sigma), px(1.3),
                      kLandmarkEllipse);
    });
    for_each_landmark(true, [&](const LandmarkView& landmark) {
      canvas_.dot(view_.to_pixel(landmark.p_map), landmark_radius(landmark.radius_m), kLandmark);
    });
  }

  void draw_reference_landmarks() {
    if (content_.reference == nullptr) return;
    for (const auto& landmark : content_.reference->landmarks) {
      const Eigen::Vector2d at = view_.to_pixel(landmark.p_map);
      const double radius = landmark.radius_m * view_.pixels_per_metre();
      if (radius > px(kSmallestLandmark)) canvas_.ring(at, radius, px(1.3), kReference);
      canvas_.cross(at, px(6), px(1.5), kReference);
    }
  }

  Points arrow(const Eigen::Vector2d& at, double yaw, double length) const {
    const Eigen::Vector2d ahead(std::cos(yaw), -std::sin(yaw));
    const Eigen::Vector2d aside(-ahead.y(), ahead.x());
    return {at + length * ahead, at - 0.7 * length * ahead + 0.65 * length * aside, at - 0.3 * length * ahead,
            at - 0.7 * length * ahead - 0.65 * length * aside};
  }

  void draw_robot() {
    if (!content_.end) return;
    for (const auto& particle : content_.end->particles) {
      canvas_.dot(view_.to_pixel(planar(particle.T_map_base)), px(1.8), kParticle);
    }
    const Pose& pose = content_.end->T_map_base;
    canvas_.outline(ellipse(view_, planar(pose), content_.end->P.topLeftCorner<2, 2>(), style_.sigma), px(1.5), kRobot);
    const Eigen::Vector2d at = view_.to_pixel(planar(pose));
    canvas_.polygon(arrow(at, pose.yaw(), px(13)), kWhite);
    canvas_.polygon(arrow(at, pose.yaw(), px(10.5)), kRobot);
  }

  void draw_labels() {
    std::size_t count = 0;
    for_each_landmark(true, [&](const LandmarkView&) { ++count; });
    const bool automatic = style_.landmark_labels == Style::Labels::automatic;
    if (style_.landmark_labels == Style::Labels::off || (automatic && count > kMostLabels)) return;
    std::vector<Rect> taken;
    for_each_landmark(true, [&](const LandmarkView& landmark) {
      const Eigen::Vector2d at = view_.to_pixel(landmark.p_map);
      const double r = landmark_radius(landmark.radius_m);
      taken.push_back({at.x() - r, at.y() - r, at.x() + r, at.y() + r});
    });
    const double size = px(8.5);
    for_each_landmark(true, [&](const LandmarkView& landmark) {
      const std::string words = fmt::format("{}", landmark.id);
      const Eigen::Vector2d at = view_.to_pixel(landmark.p_map);
      // Beside the ellipse as well, unless that is so large that the number would lose its landmark.
      const double spread = style_.sigma * std::sqrt(std::max(0.0, landmark.P(0, 0))) * view_.pixels_per_metre();
      const double radius = landmark_radius(landmark.radius_m);
      const double away = px(4) + std::max(radius, std::min(spread, px(30)));
      const double width = Canvas::text_width(words, size);
      const std::array<Eigen::Vector2d, 4> places{Eigen::Vector2d(at.x() + away, at.y() + 0.5 * size),
                                                  Eigen::Vector2d(at.x() - away - width, at.y() + 0.5 * size),
                                                  Eigen::Vector2d(at.x() - 0.5 * width, at.y() - away),
                                                  Eigen::Vector2d(at.x() - 0.5 * width, at.y() + away + size)};
      for (const Eigen::Vector2d& place : places) {
        const Rect box{place.x() - px(1), place.y() - size - px(1), place.x() + width + px(1), place.y() + px(1)};
        const bool free =
            std::none_of(taken.begin(), taken.end(), [&](const Rect& other) { return other.overlaps(box); });
        if (!free && automatic) continue;
        taken.push_back(box);
        canvas_.text(place, words, size, kInk, px(1));
        break;
      }
    });
  }

  void draw_scale_bar() {
    const Rect& area = view_.area();
    const double metres = round_step(px(110) / view_.pixels_per_metre());
    const double length = metres * view_.pixels_per_metre();
    const std::string words = metres >= 1000.0 ? fmt::format("{:g} km", 1e-3 * metres) : fmt::format("{:g} m", metres);
    const double left = area.left + px(22);
    const double y = area.bottom - px(22);
    canvas_.box({left - px(10), y - px(30), left + length + px(10), y + px(12)}, kWhite);
    canvas_.line({left, y}, {left + length, y}, px(2), kInk);
    for (const double x : {left, left + length}) canvas_.line({x, y - px(5)}, {x, y + px(5)}, px(2), kInk);
    canvas_.text({left + 0.5 * (length - Canvas::text_width(words, px(11))), y - px(11)}, words, px(11), kInk, px(1.2));
  }

  void draw_no_data() {
    const Rect& area = view_.area();
    const Eigen::Vector2d centre(0.5 * (area.left + area.right), 0.5 * (area.top + area.bottom));
    const std::string words = "no data";
    const std::string reason = "the filter did not start";
    const double width = std::max(Canvas::text_width(words, px(30)), Canvas::text_width(reason, px(14)));
    canvas_.box({centre.x() - 0.5 * width - px(24), centre.y() - px(46), centre.x() + 0.5 * width + px(24),
                 centre.y() + px(56)},
                kWhite);
    canvas_.text(centre - Eigen::Vector2d(0.5 * Canvas::text_width(words, px(30)), 0.0), words, px(30), kInk, px(2.5));
    canvas_.text(centre + Eigen::Vector2d(-0.5 * Canvas::text_width(reason, px(14)), px(38)), reason, px(14), kSoftInk,
                 px(1.2));
  }

  void draw_title() {
    std::vector<std::string> parts{"log " + duration_text(content_.log_duration_s)};
    if (content_.end) {
      const std::size_t particles = content_.end->particles.size();
      if (particles > 0) parts.push_back(fmt::format("{} particle{}", particles, particles == 1 ? "" : "s"));
      if (std::ranges::any_of(content_.end->maps, [](const MapDescription& map) { return !map.grid; })) {
        std::size_t confirmed = 0;
        for_each_landmark(true, [&](const LandmarkView&) { ++confirmed; });
        parts.push_back(fmt::format("{} landmark{}", confirmed, confirmed == 1 ? "" : "s"));
      }
    }
    if (content_.interrupted) parts.emplace_back("interrupted");
    const std::string words = fmt::format("{}", fmt::join(parts, "  |  "));
    const double middle = 0.5 * (view_.area().left + view_.area().right);
    canvas_.text({middle - 0.5 * Canvas::text_width(words, px(15)), px(38)}, words, px(15), kInk, px(1.6));
  }

  void draw_panel();

  const Content& content_;
  const Style& style_;
  double unit_;
  Canvas canvas_;
  View view_;
};

void Painter::draw_panel() {
  const double left = view_.area().right + px(26);
  const double sample = px(34);
  double y = view_.area().top + px(12);
  const auto entry = [&](bool present, const std::string& words,
                         const std::function<void(Eigen::Vector2d, Eigen::Vector2d)>& mark) {
    if (!present) return;
    mark({left, y}, {left + sample, y});
    canvas_.text({left + sample + px(14), y + px(5)}, words, px(11), kInk, px(1.1));
    y += px(30);
  };
  const auto stroke = [&](double width, Color color) {
    return [&, width, color](Eigen::Vector2d a, Eigen::Vector2d b) { canvas_.line(a, b, px(width), color); };
  };
  const auto blob = [&](double radius, Color color) {
    return [&, radius, color](Eigen::Vector2d a, Eigen::Vector2d b) { canvas_.dot(0.5 * (a + b), px(radius), color); };
  };
  const auto oval = [&](double width, Color color) {
    return [&, width, color](Eigen::Vector2d a, Eigen::Vector2d b) {
      Points points;
      for (int i = 0; i < 48; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / 48;
        points.emplace_back(0.5 * (a + b) + Eigen::Vector2d(px(13) * std::cos(angle), px(7) * std::sin(angle)));
      }
      canvas_.outline(points, px(width), color);
    };
  };
  const std::string ellipse_name = fmt::format("{:g}-sigma ellipse", style_.sigma);

  std::size_t confirmed = 0;
  std::size_t provisional = 0;
  for_each_landmark(true, [&](const LandmarkView&) { ++confirmed; });
  for_each_landmark(false, [&](const LandmarkView&) { ++provisional; });
  const bool known = content_.reference != nullptr;

  entry(content_.online.size() > 1, "estimate, online", stroke(3.5, kEstimate));
  entry(style_.ellipses && !content_.uncertainty.empty(), "its " + ellipse_name, oval(1.0, kUncertainty));
  entry(content_.end && content_.end->best_path.size() > 1, "path of the best particle", stroke(0.7, kBestPath));
  entry(known && content_.reference->trajectory.size() > 1, "reference", stroke(2.5, kReference));
  entry(content_.gnss_fused_count > 0, fmt::format("GNSS, fused ({})", content_.gnss_fused_count), blob(3.0, kFused));
  entry(content_.gnss_held_out_count > 0, fmt::format("GNSS, held out ({})", content_.gnss_held_out_count),
        blob(3.0, kHeldOut));
  const bool dense =
      content_.end && std::ranges::any_of(content_.end->maps, [](const auto& map) { return map.grid.has_value(); });
  entry(dense, "occupied", [&](Eigen::Vector2d a, Eigen::Vector2d b) {
    canvas_.box({a.x() + px(10), a.y() - px(6), b.x() - px(10), b.y() + px(6)}, kOccupiedCell);
  });
  entry(dense, "free", [&](Eigen::Vector2d a, Eigen::Vector2d b) {
    const Rect area{a.x() + px(10), a.y() - px(6), b.x() - px(10), b.y() + px(6)};
    canvas_.box(area, kFreeCell);
    canvas_.frame(area, px(1), kFrame);
  });
  entry(dense && style_.disagreement, "particles differ", [&](Eigen::Vector2d a, Eigen::Vector2d b) {
    canvas_.box({a.x() + px(10), a.y() - px(6), b.x() - px(10), b.y() + px(6)}, kDisputedCell);
  });
  entry(confirmed > 0, fmt::format("landmark ({})", confirmed), blob(5.0, kLandmark));
  entry(confirmed > 0, "its " + ellipse_name, oval(1.3, kLandmarkEllipse));
  entry(provisional > 0, fmt::format("provisional ({})", provisional),
        [&](Eigen::Vector2d a, Eigen::Vector2d b) { canvas_.ring(0.5 * (a + b), px(5), px(1.5), kProvisional); });
  entry(known && !content_.reference->landmarks.empty(),
        fmt::format("surveyed landmark ({})", known ? content_.reference->landmarks.size() : 0),
        [&](Eigen::Vector2d a, Eigen::Vector2d b) { canvas_.cross(0.5 * (a + b), px(5), px(1.3), kReference); });
  entry(content_.end && !content_.end->particles.empty(), "particles at the end", blob(2.5, kParticle));
  entry(content_.end.has_value(), "robot at the end",
        [&](Eigen::Vector2d a, Eigen::Vector2d b) { canvas_.polygon(arrow(0.5 * (a + b), 0.0, px(11)), kRobot); });
  entry(content_.end.has_value(), "its " + ellipse_name, oval(1.5, kRobot));
  if (!content_.end) return;

  y += px(16);
  const auto row = [&](const std::string& name, const std::string& value) {
    canvas_.text({left, y}, name, px(10), kSoftInk, px(1));
    canvas_.text({left + px(64), y}, value, px(10), kInk, px(1));
    y += px(25);
  };
  const Pose& pose = content_.end->T_map_base;
  const Eigen::Vector3d deviation = content_.end->P.diagonal().cwiseMax(0.0).cwiseSqrt();
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  canvas_.text({left, y}, "Pose at the end (1 sigma)", px(11), kInk, px(1.1));
  y += px(30);
  row("east", fmt::format("{:.2f} +- {:.2f} m", pose.p.x() + content_.axes.origin.x(), deviation.x()));
  row("north", fmt::format("{:.2f} +- {:.2f} m", pose.p.y() + content_.axes.origin.y(), deviation.y()));
  row("yaw", fmt::format("{:.1f} +- {:.1f} deg", pose.yaw() * kDegrees, deviation.z() * kDegrees));
}

}  // namespace

std::string draw(const Content& content, const Style& style) { return Painter(content, style).paint(); }

}  // namespace waymark::plot
