// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "exact_stamp.hpp"
#include "health_json.hpp"
#include "map_figures_log.hpp"
#include "thinned_series.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/pose_modes.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::diagnostics {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxBadRecords = 100;

/// JSON has no NaN and no infinity: null.
Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json ratio(double numerator, double denominator) {
  return denominator > 0.0 ? finite(numerator / denominator) : Json(nullptr);
}

template <std::size_t Columns>
Json table(const ThinnedSeries<Columns>& series) {
  Json rows = Json::array();
  for (const auto& row : series.rows()) {
    Json cells = Json::array();
    cells.push_back(ExactStamp::json(row.stamp));
    for (const double cell : row.values) cells.push_back(finite(cell));
    rows.push_back(std::move(cells));
  }
  return rows;
}

Json describe(const SensorReport& sensor) {
  const double between = static_cast<double>(sensor.measurements) - 1.0;
  return {{"name", sensor.name},
          {"plugin", sensor.plugin},
          {"measurements", sensor.measurements},
          {"rate_hz", ratio(std::max(between, 0.0), to_seconds(sensor.last - sensor.first))},
          {"fused", sensor.fused},
          {"gated", sensor.gated},
          {"mapped", sensor.mapped},
          {"skipped", sensor.skipped},
          {"held_out", sensor.held_out},
          {"late", sensor.late},
          {"before_start", sensor.before_start},
          {"unusable", sensor.unusable},
          {"ignored", sensor.ignored},
          {"mistimed", sensor.mistimed},
          {"processed_late", sensor.processed_late},
          {"reordered", sensor.reordered},
          {"latency_mean_s", finite(sensor.latency_mean_s)},
          {"latency_max_s", finite(sensor.latency_max_s)},
          {"gap_max_s", finite(sensor.gap_max_s)},
          {"mean_nis", ratio(sensor.nis_sum, static_cast<double>(sensor.nis_count))},
          {"expected_nis", ratio(static_cast<double>(sensor.nis_dof), static_cast<double>(sensor.nis_count))},
          {"nis_count", sensor.nis_count},
          {"nis_dof", sensor.nis_dof}};
}

/// Length of the log over all sensors; null without measurements.
Json duration_s(const RunReport& report) {
  Time first = Time::max();
  Time last = Time::min();
  for (const SensorReport& sensor : report.sensors) {
    if (sensor.measurements == 0) continue;
    first = std::min(first, sensor.first);
    last = std::max(last, sensor.last);
  }
  return first <= last ? Json(to_seconds(last - first)) : Json(nullptr);
}

Json describe(const std::vector<MatchReport>& maps) {
  Json out = Json::array();
  for (const MatchReport& map : maps) {
    out.push_back({{"map", map.map}, {"matches", map.matches}, {"failed", map.failed}, {"searches", map.searches}});
  }
  return out;
}

Json describe(const RunReport& report) {
  Json records = Json::array();
  for (const BadRecord& record : report.bad_records) {
    if (records.size() == kMaxBadRecords) break;
    records.push_back({{"place", record.place}, {"reason", record.reason}});
  }
  Json events = Json::array();
  for (const Event& event : report.events) {
    events.push_back({{"t_s", ExactStamp::json(event.stamp)}, {"text", event.text}});
  }
  return {{"interrupted", report.interrupted},
          {"duration_s", duration_s(report)},
          {"mapping_steps", report.mapping_steps},
          {"resamplings", report.resamplings},
          {"matches", describe(report.matches)},
          {"bad_record_count", report.bad_records.size()},
          {"bad_records", std::move(records)},
          {"notices", report.notices},
          {"events", std::move(events)}};
}

Json describe(const std::vector<Finding>& findings) {
  Json all = Json::array();
  for (const Finding& finding : findings) {
    all.push_back({{"certainty", to_string(finding.certainty)},
                   {"check", finding.check},
                   {"sensors", finding.sensors},
                   {"seen", finding.seen},
                   {"change", finding.change},
                   {"sigmas", finite(finding.sigmas)},
                   {"t_s", ExactStamp::json(finding.stamp)}});
  }
  return all;
}

Json describe(const std::optional<Datum>& datum) {
  if (!datum) return nullptr;
  return {
      {"latitude_deg", datum->latitude_deg}, {"longitude_deg", datum->longitude_deg}, {"height_m", datum->height_m}};
}

/// The places and headings at which the particles have the robot at the end.
Json modes_of(const Snapshot& last) {
  ModeFinder finder;
  Json modes = Json::array();
  for (const PoseMode& mode : finder.find(last.particles())) {
    const Pose& pose = mode.T_map_base;
    modes.push_back({{"x_m", pose.p.x()}, {"y_m", pose.p.y()}, {"yaw_rad", pose.yaw()}, {"weight", mode.weight}});
  }
  return modes;
}

Json describe(const LatencyReport& latency) {
  return {{"median", latency.median}, {"p99", latency.p99}, {"max", latency.max}};
}

Json describe(const LiveReport& live) {
  Json streams = Json::array();
  for (const LiveReport::Stream& stream : live.streams) {
    streams.push_back({{"sensor", stream.sensor},
                       {"received", stream.received},
                       {"dropped", stream.dropped},
                       {"missing", stream.missing},
                       {"waits", stream.waits},
                       {"clock_offset_s", stream.clock_offset_s},
                       {"clock_drift", stream.clock_drift},
                       {"latency_s", describe(stream.latency_s)}});
  }
  return {{"duration_s", live.duration_s},
          {"cpu_share", live.cpu_share},
          {"front_latency_s", describe(live.front_latency_s)},
          {"streams", std::move(streams)}};
}

Json count_landmarks(const Snapshot& last) {
  Json maps = Json::array();
  for (const MapDescription& map : last.best_maps(MapDetail::summary)) {
    const auto confirmed = std::ranges::count_if(map.landmarks, &LandmarkView::confirmed);
    const auto provisional = static_cast<std::ptrdiff_t>(map.landmarks.size()) - confirmed;
    Json figures = Json::object();
    for (const MapFigure& figure : map.figures) figures[figure.name] = finite(figure.value);
    maps.push_back(
        {{"map", map.module}, {"confirmed", confirmed}, {"provisional", provisional}, {"figures", std::move(figures)}});
  }
  return maps;
}

/// How the run went, as JSON.
class Diagnostics : public Sink {
 public:
  explicit Diagnostics(const Config& config)
      : name_(config.output({"file", "file name in the output folder"}, "diagnostics.json")),
        map_figures_name_(config.output({"map_figures_file", "file name of the maps' figures in the output folder"},
                                        "map_figures.csv")),
        map_figures_every_(from_seconds(config.non_negative(
            {"map_figures_every_s", "s",
             "the figures of the maps over time, every so many seconds of the log; 0: they are not written"},
            0.0))) {}

  void start(const RunInfo& info) override {
    path_ = info.out_dir / name_;
    if (map_figures_every_ > Duration::zero())
      map_figures_.emplace(info.out_dir / map_figures_name_, map_figures_every_);
  }

  void write(const Snapshot& snapshot) override {
    has_started_ = has_started_ || snapshot.started();
    if (!has_started_) return;
    const Time t = snapshot.stamp();
    health_.add(t, snapshot.health());
    if (!snapshot.started()) return;  // the pose is lost
    if (map_figures_) map_figures_->look(snapshot);
    const double n_eff = snapshot.effective_sample_size();
    if (std::isfinite(n_eff)) smallest_n_eff_ = std::min(smallest_n_eff_, n_eff);
    n_eff_.add({t, {n_eff}});
    if (sigma_.wants_next()) {
      const Eigen::Vector3d variance = pose_covariance(snapshot.belief(), snapshot.layout()).diagonal();
      // Rounding may leave a variance a hair below zero.
      const Eigen::Vector3d sigma = variance.cwiseMax(0.0).cwiseSqrt();
      sigma_.add({t, {sigma.x(), sigma.y(), sigma.z()}});
    } else {
      sigma_.skip();
    }
  }

  void finish(const Snapshot* last, const RunReport& report) override {
    const bool started = last != nullptr && last->started();
    if (map_figures_) map_figures_->finish(started ? last : nullptr);
    Json sensors = Json::array();
    for (const SensorReport& sensor : report.sensors) sensors.push_back(describe(sensor));
    Json document = {{"run", describe(report)},
                     {"datum", last != nullptr ? describe(last->datum()) : Json(nullptr)},
                     {"health", health_json(health_, report)},
                     {"findings", describe(report.findings)},
                     {"sensors", std::move(sensors)},
                     {"particles", started ? last->particles().size() : 0},
                     {"modes", started ? modes_of(*last) : Json::array()},
                     {"effective_sample_size",
                      {{"min", finite(smallest_n_eff_)}, {"median", median_n_eff()}, {"over_time", table(n_eff_)}}},
                     {"landmarks", started ? count_landmarks(*last) : Json::array()},
                     {"pose_sigma", {{"columns", {"t_s", "x_m", "y_m", "yaw_rad"}}, {"over_time", table(sigma_)}}}};
    if (report.live) document["live"] = describe(*report.live);
    write_file(path_, ExactStamp::dump(document) + "\n");
  }

 private:
  Json median_n_eff() const {
    std::vector<double> values;
    for (const auto& row : n_eff_.rows()) {
      if (std::isfinite(row.values[0])) values.push_back(row.values[0]);
    }
    if (values.empty()) return nullptr;
    std::ranges::sort(values);
    const std::size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
  }

  std::string name_;
  std::string map_figures_name_;
  Duration map_figures_every_;  // zero: not written
  std::optional<MapFiguresLog> map_figures_;
  std::filesystem::path path_;
  bool has_started_ = false;
  static constexpr std::size_t kMostChanges = 1000;
  run_views::HealthChanges health_{kMostChanges, run_views::HealthChanges::Before::ok};
  double smallest_n_eff_ = std::numeric_limits<double>::infinity();
  ThinnedSeries<1> n_eff_;
  ThinnedSeries<3> sigma_;
};

}  // namespace
}  // namespace waymark::diagnostics

WAYMARK_PLUGIN(waymark::Sink, waymark::diagnostics::Diagnostics, "diagnostics", "1.0.0")
