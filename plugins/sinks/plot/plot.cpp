// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "picture.hpp"
#include "utm.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::plot {
namespace {

/// Keeps every n-th point; n doubles whenever there are too many, so memory is bounded and the choice depends on the
/// data only.
class ThinnedPoints {
 public:
  void add(const Eigen::Vector2d& point) {
    last_ = point;
    if (count_++ % stride_ != 0) return;
    points_.push_back(point);
    if (points_.size() < kLimit) return;
    for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = points_[2 * i];
    points_.resize((points_.size() + 1) / 2);
    stride_ *= 2;
  }

  std::size_t count() const { return count_; }
  /// The kept points and the last one.
  std::vector<Eigen::Vector2d> points() const {
    std::vector<Eigen::Vector2d> out = points_;
    if (count_ > 0 && (count_ - 1) % stride_ != 0) out.push_back(last_);
    return out;
  }

 private:
  static constexpr std::size_t kLimit = 1 << 16;
  std::vector<Eigen::Vector2d> points_;
  Eigen::Vector2d last_ = Eigen::Vector2d::Zero();
  std::size_t count_ = 0;
  std::size_t stride_ = 1;
};

/// Beliefs about the position along the way, evenly spread over the distance: the spacing doubles whenever there are
/// too many.
class SpreadBeliefs {
 public:
  void add(const Eigen::Vector2d& position, const Eigen::Matrix2d& P) {
    if (!beliefs_.empty() && (position - beliefs_.back().position).norm() < spacing_m_) return;
    beliefs_.push_back({position, P});
    if (beliefs_.size() < kLimit) return;
    for (std::size_t i = 0; 2 * i < beliefs_.size(); ++i) beliefs_[i] = beliefs_[2 * i];
    beliefs_.resize((beliefs_.size() + 1) / 2);
    spacing_m_ *= 2.0;
  }
  const std::vector<Content::PositionBelief>& beliefs() const { return beliefs_; }

 private:
  static constexpr std::size_t kLimit = 80;
  double spacing_m_ = 0.5;
  std::vector<Content::PositionBelief> beliefs_;
};

/// Draws the run as one map when it is over.
class Plot : public Sink {
 public:
  explicit Plot(const Config& config)
      : file_(config.output({"file", "file name in the output folder, ends in `.png`"}, "map.png")) {
    style_.width_px =
        static_cast<int>(config.integer_in({"width_px", "px", "width of the picture"}, 480, 10000, style_.width_px));
    style_.height_px =
        static_cast<int>(config.integer_in({"height_px", "px", "height of the picture"}, 360, 10000, style_.height_px));
    style_.sigma = config.positive({"sigma", "standard deviations of every ellipse"}, style_.sigma);
    style_.ellipses = config.boolean({"ellipses", "false: no ellipses along the estimate"}, style_.ellipses);
    style_.disagreement =
        config.boolean({"disagreement",
                        "true: of dense maps, all particles' together are drawn (also where that of the "
                        "best one is unknown); cells that some take for occupied and others for free are orange"},
                       style_.disagreement);
    if (config.has("window_m")) style_.window = read_window(config);
    if (config.has("utm_origin_deg")) origin_ = read_origin(config);
    const std::string labels =
        config.choice({"landmark_labels", "`auto`: up to 60 landmarks are labelled, and none over another"},
                      {"auto", "on", "off"}, "auto");
    style_.landmark_labels = labels == "on"    ? Style::Labels::on
                             : labels == "off" ? Style::Labels::off
                                               : Style::Labels::automatic;
    if (file_.extension() != ".png") config.fail("file", "\"" + file_.string() + "\" does not end in .png");
  }

  void start(const RunInfo& info) override {
    out_dir_ = info.out_dir;
    reference_ = info.reference;
  }

  void write(const Snapshot& snapshot) override {
    const Measurement& measurement = snapshot.measurement();
    if (!any_) first_ = last_ = measurement.stamp;
    any_ = true;
    first_ = std::min(first_, measurement.stamp);
    last_ = std::max(last_, measurement.stamp);
    if (measurement.payload != nullptr && measurement.payload->type() == GnssFix::kType) {
      const Eigen::Vector2d p = measurement.as<GnssFix>().p_map_antenna.head<2>();
      if (p.allFinite() && snapshot.fate() == Fate::fused) fused_.add(p);
      if (p.allFinite() && snapshot.fate() == Fate::held_out) held_out_.add(p);
    }
    if (!snapshot.started()) return;
    const Belief& belief = snapshot.belief();
    online_.add(belief.mean.T_map_base.p.head<2>());
    // With maps the covariance means most at mapping steps: of the refined mixture, before it is sampled.
    maps_ = maps_ || snapshot.fate() == Fate::mapped;
    if (maps_ && snapshot.fate() != Fate::mapped) return;
    uncertainty_.add(belief.mean.T_map_base.p.head<2>(),
                     pose_covariance(belief, snapshot.layout()).topLeftCorner<2, 2>());
  }

  void finish(const Snapshot* last, const RunReport& report) override {
    Content content;
    content.reference = reference_;
    content.online = online_.points();
    content.uncertainty = uncertainty_.beliefs();
    content.gnss_fused = fused_.points();
    content.gnss_held_out = held_out_.points();
    content.gnss_fused_count = fused_.count();
    content.gnss_held_out_count = held_out_.count();
    content.log_duration_s = to_seconds(last_ - first_);
    content.interrupted = report.interrupted;
    if (last != nullptr && last->started()) {
      content.end = Content::End{
          last->belief().mean.T_map_base, pose_covariance(last->belief(), last->layout()), last->particles(),
          last->best_path(), last->best_maps(style_.disagreement ? MapDetail::with_mixtures : MapDetail::with_grids)};
    }
    if (origin_) to_utm(content, *origin_);
    write_file(out_dir_ / file_, draw(content, style_));
  }

 private:
  static Style::Window read_window(const Config& config) {
    const std::vector<double> corners = config.numbers(
        {"window_m", "m",
         "east_min, north_min, east_max, north_max: the part that is shown, counted from the map's origin",
         "everything"},
        4);
    if (!(corners[0] < corners[2] && corners[1] < corners[3]))
      config.fail("window_m", "east_min, north_min, east_max, north_max are expected, each minimum below its maximum");
    return {{corners[0], corners[1]}, {corners[2], corners[3]}};
  }

  static Origin read_origin(const Config& config) {
    const std::vector<double> origin = config.numbers({"utm_origin_deg", "°",
                                                       "latitude and longitude of the map's origin: the picture is in "
                                                       "UTM then, and so is the window, counted from the origin",
                                                       "none"},
                                                      2);
    // Beyond, the Earth is mapped by UPS.
    if (!(origin[0] > -80.0 && origin[0] < 84.0 && std::abs(origin[1]) <= 180.0))
      config.fail("utm_origin_deg", "latitude (-80 to 84) and longitude (-180 to 180) are expected");
    return {origin[0], origin[1]};
  }

  std::filesystem::path file_;
  std::optional<Origin> origin_;
  Style style_;
  std::filesystem::path out_dir_;
  std::shared_ptr<const Reference> reference_;
  ThinnedPoints online_;
  ThinnedPoints fused_;
  ThinnedPoints held_out_;
  SpreadBeliefs uncertainty_;
  bool maps_ = false;
  bool any_ = false;
  Time first_{};
  Time last_{};
};

}  // namespace
}  // namespace waymark::plot

WAYMARK_PLUGIN(waymark::Sink, waymark::plot::Plot, "plot", "1.0.0")
