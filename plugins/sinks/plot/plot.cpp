// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "picture.hpp"
#include "plugins/shared/run_views/fix_track.hpp"
#include "plugins/shared/run_views/reference_frame.hpp"
#include "plugins/shared/run_views/thinned.hpp"
#include "utm.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::plot {
namespace {

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
    name_ = info.name;
  }

  void write(const Snapshot& snapshot) override {
    const Measurement& measurement = snapshot.measurement();
    if (!any_) first_ = last_ = measurement.stamp;
    any_ = true;
    first_ = std::min(first_, measurement.stamp);
    last_ = std::max(last_, measurement.stamp);
    fixes_.add(snapshot);
    if (!snapshot.started()) return;
    const Belief& belief = snapshot.belief();
    if (online_.wants_next()) {
      const Eigen::Matrix3d P = pose_covariance(belief, snapshot.layout());
      const auto sigma = [](double variance) { return std::sqrt(std::max(variance, 0.0)); };
      online_.add({snapshot.stamp(), belief.mean.T_map_base, sigma(std::max(P(0, 0), P(1, 1))), sigma(P(2, 2))});
    } else {
      online_.add({snapshot.stamp(), belief.mean.T_map_base, 0.0, 0.0});
    }
    // With maps the covariance means most at mapping steps: of the refined mixture, before it is sampled.
    maps_ = maps_ || snapshot.fate() == Fate::mapped;
    if (maps_ && snapshot.fate() != Fate::mapped) return;
    uncertainty_.add(belief.mean.T_map_base.p.head<2>(),
                     pose_covariance(belief, snapshot.layout()).topLeftCorner<2, 2>());
  }

  void finish(const Snapshot* last, const RunReport& report) override {
    Content content;
    content.name = name_;
    content.log_start = first_;
    for (const run_views::Estimate& estimate : online_.elements())
      content.online.emplace_back(estimate.T_map_base.p.head<2>());
    take_reference(content);
    content.uncertainty = uncertainty_.beliefs();
    take_fixes(content, last != nullptr ? last->datum() : std::nullopt);
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

  void take_reference(Content& content) const {
    if (reference_ == nullptr) return;
    const run_views::ReferenceFrame frame = run_views::frame_of(*reference_, online_.elements());
    content.reference = run_views::in_map(reference_, frame);
    content.reference_is_aligned = frame.is_aligned;
  }

  void take_fixes(Content& content, const std::optional<Datum>& datum) const {
    using Kind = run_views::FixTrack::Kind;
    content.gnss_fused = fixes_.positions(Kind::used, datum);
    content.gnss_rejected = fixes_.positions(Kind::rejected, datum);
    content.gnss_held_out = fixes_.positions(Kind::held_out, datum);
    content.gnss_fused_count = fixes_.count(Kind::used);
    content.gnss_rejected_count = fixes_.count(Kind::rejected);
    content.gnss_held_out_count = fixes_.count(Kind::held_out);
  }

  std::filesystem::path file_;
  std::string name_;
  std::optional<Origin> origin_;
  Style style_;
  std::filesystem::path out_dir_;
  std::shared_ptr<const Reference> reference_;
  run_views::Thinned<run_views::Estimate, 1 << 16> online_;
  run_views::FixTrack fixes_;
  SpreadBeliefs uncertainty_;
  bool maps_ = false;
  bool any_ = false;
  Time first_{};
  Time last_{};
};

}  // namespace
}  // namespace waymark::plot

WAYMARK_PLUGIN(waymark::Sink, waymark::plot::Plot, "plot", "1.0.0")
