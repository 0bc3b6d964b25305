// SPDX-License-Identifier: Apache-2.0
// What is drawn how, and the pose at the end.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <string>

#include "framing.hpp"
#include "plugins/shared/run_views/titles.hpp"
#include "sheet.hpp"

namespace waymark::plot {
namespace {

/// Entries of the legend, one below the other, to the right of the map.
class Legend {
 public:
  explicit Legend(Sheet& sheet)
      : sheet_(sheet),
        left_(sheet.view.area().right + sheet.px(26)),
        y_(sheet.view.area().top + sheet.px(12)),
        ellipse_name_(fmt::format("its {:g}σ ellipse", sheet.style.sigma)) {}

  void add_trajectories() {
    const Content& content = sheet_.content;
    const Seen& seen = sheet_.seen;
    entry(seen.online > 1, "estimate, online", stroke(3.5, kEstimate));
    entry(seen.uncertainty > 0, ellipse_name_, oval(1.0, kUncertainty));
    entry(seen.path > 1, "path of the best particle", stroke(0.7, kBestPath));
    entry(seen.reference > 1, content.reference_is_aligned ? "reference, aligned" : "reference",
          stroke(2.5, kReference));
    entry(seen.fused > 0, fmt::format("GNSS, fused ({})", content.gnss_fused_count), blob(3.0, kFused));
    entry(seen.rejected > 0, fmt::format("GNSS, rejected ({})", content.gnss_rejected_count), blob(3.0, kRejected));
    entry(seen.held_out > 0, fmt::format("GNSS, held out ({})", content.gnss_held_out_count), blob(3.0, kHeldOut));
  }

  void add_maps() {
    const Content& content = sheet_.content;
    const bool dense =
        content.end && std::ranges::any_of(content.end->maps, [](const auto& map) { return map.grid.has_value(); });
    entry(dense, "occupied",
          [&](Eigen::Vector2d a, Eigen::Vector2d b) { sheet_.canvas.box(cell(a, b), kOccupiedCell); });
    entry(dense, "free", [&](Eigen::Vector2d a, Eigen::Vector2d b) {
      sheet_.canvas.box(cell(a, b), kFreeCell);
      sheet_.canvas.frame(cell(a, b), sheet_.px(1), kFrame);
    });
    entry(dense && sheet_.style.disagreement, "particles differ",
          [&](Eigen::Vector2d a, Eigen::Vector2d b) { sheet_.canvas.box(cell(a, b), kDisputedCell); });
    std::size_t confirmed = 0;
    std::size_t provisional = 0;
    sheet_.for_each_landmark(true, [&](const LandmarkView&) { ++confirmed; });
    sheet_.for_each_landmark(false, [&](const LandmarkView&) { ++provisional; });
    entry(sheet_.seen.landmarks > 0, fmt::format("landmark ({})", confirmed), blob(5.0, kLandmark));
    entry(sheet_.seen.landmark_ellipses > 0, ellipse_name_, oval(1.3, kLandmarkEllipse));
    entry(sheet_.seen.provisional > 0, fmt::format("provisional ({})", provisional),
          [&](Eigen::Vector2d a, Eigen::Vector2d b) {
            sheet_.canvas.ring(0.5 * (a + b), sheet_.px(5), sheet_.px(1.5), kProvisional);
          });
    const std::size_t surveyed = content.reference != nullptr ? content.reference->landmarks.size() : 0;
    entry(sheet_.seen.surveyed > 0, fmt::format("surveyed landmark ({})", surveyed),
          [&](Eigen::Vector2d a, Eigen::Vector2d b) {
            sheet_.canvas.cross(0.5 * (a + b), sheet_.px(5), sheet_.px(1.3), kReference);
          });
  }

  void add_robot() {
    entry(sheet_.seen.particles > 0, "particles at the end", blob(2.5, kParticle));
    entry(sheet_.seen.modes > 0, "one of several places of the particles", [&](Eigen::Vector2d a, Eigen::Vector2d b) {
      sheet_.canvas.polygon(arrow(0.5 * (a + b), 0.0, sheet_.px(9)), kParticle);
    });
    entry(sheet_.seen.robot > 0, "robot at the end", [&](Eigen::Vector2d a, Eigen::Vector2d b) {
      sheet_.canvas.polygon(arrow(0.5 * (a + b), 0.0, sheet_.px(11)), kRobot);
    });
    entry(sheet_.seen.robot_ellipse > 0, ellipse_name_, oval(1.5, kRobot));
  }

  /// In numbers, with σ.
  void add_pose(const Content::End& end) {
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    const Eigen::Vector3d deviation = end.P.diagonal().cwiseMax(0.0).cwiseSqrt();
    const Eigen::Vector2d place = end.T_map_base.p.head<2>() + sheet_.content.axes.origin;
    y_ += sheet_.px(16);
    sheet_.canvas.text({left_, y_}, "Pose at the end (1σ)", sheet_.px(11), kInk, sheet_.px(1.1));
    y_ += sheet_.px(30);
    row("east", run_views::value_text(place.x(), deviation.x()) + " m");
    row("north", run_views::value_text(place.y(), deviation.y()) + " m");
    row("yaw", run_views::value_text(end.T_map_base.yaw() * kDegrees, deviation.z() * kDegrees) + "°");
  }

 private:
  /// Draws a sample between two points on one height.
  using Mark = std::function<void(Eigen::Vector2d, Eigen::Vector2d)>;

  void entry(bool present, const std::string& words, const Mark& mark) {
    if (!present) return;
    const double sample = sheet_.px(34);
    mark({left_, y_}, {left_ + sample, y_});
    sheet_.canvas.text({left_ + sample + sheet_.px(14), y_ + sheet_.px(5)}, words, sheet_.px(11), kInk, sheet_.px(1.1));
    y_ += sheet_.px(30);
  }

  void row(const std::string& name, const std::string& value) {
    sheet_.canvas.text({left_, y_}, name, sheet_.px(10), kSoftInk, sheet_.px(1));
    sheet_.canvas.text({left_ + sheet_.px(64), y_}, value, sheet_.px(10), kInk, sheet_.px(1));
    y_ += sheet_.px(25);
  }

  Rect cell(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    return {a.x() + sheet_.px(10), a.y() - sheet_.px(6), b.x() - sheet_.px(10), b.y() + sheet_.px(6)};
  }

  Mark stroke(double width, Color color) {
    return [this, width, color](Eigen::Vector2d a, Eigen::Vector2d b) {
      sheet_.canvas.line(a, b, sheet_.px(width), color);
    };
  }

  Mark blob(double radius, Color color) {
    return [this, radius, color](Eigen::Vector2d a, Eigen::Vector2d b) {
      sheet_.canvas.dot(0.5 * (a + b), sheet_.px(radius), color);
    };
  }

  Mark oval(double width, Color color) {
    return [this, width, color](Eigen::Vector2d a, Eigen::Vector2d b) {
      Points points;
      for (int i = 0; i < 48; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / 48;
        points.emplace_back(0.5 * (a + b) +
                            Eigen::Vector2d(sheet_.px(13) * std::cos(angle), sheet_.px(7) * std::sin(angle)));
      }
      sheet_.canvas.outline(points, sheet_.px(width), color);
    };
  }

  Sheet& sheet_;
  double left_;
  double y_;
  std::string ellipse_name_;
};

}  // namespace

void draw_legend(Sheet& sheet) {
  Legend legend(sheet);
  legend.add_trajectories();
  legend.add_maps();
  legend.add_robot();
  if (sheet.content.end) legend.add_pose(*sheet.content.end);
}

}  // namespace waymark::plot
