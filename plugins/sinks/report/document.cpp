// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

#include "content.hpp"
#include "grid_image.hpp"
#include "numbers.hpp"
#include "plugins/shared/run_views/reference_frame.hpp"
#include "plugins/shared/run_views/titles.hpp"
#include "waymark/interface/pose_modes.hpp"
#include "waymark/interface/sensor_summary.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::report {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr std::size_t kMostLinePoints = 6000;
constexpr std::size_t kMostTexts = 500;

class Document {
 public:
  explicit Document(const Content& content) : c_(content) {}

  Json whole() const {
    Json document = {{"name", c_.name},
                     {"date", run_views::date_text(c_.first)},
                     {"duration", run_views::duration_text(to_seconds(c_.last - c_.first))},
                     {"duration_s", seconds(c_.last)},
                     {"interrupted", c_.run.interrupted},
                     {"spatial", c_.is_spatial},
                     {"started", !c_.track.empty()},
                     {"track", track()},
                     {"states", states()},
                     {"reference", reference()},
                     {"fixes", fixes()},
                     {"outages", outages()},
                     {"health", health()},
                     {"sensors", sensors()},
                     {"sensor_series", sensor_series()},
                     {"map", map()},
                     {"events", events()},
                     {"findings", findings()},
                     {"notices", texts(c_.run.notices)},
                     {"bad_records", bad_records()},
                     {"config", c_.config}};
    if (c_.run.live) document["live"] = live(*c_.run.live);
    return document;
  }

 private:
  /// Since the first measurement.
  Json seconds(Time stamp) const { return decimals(to_seconds(stamp - c_.first), 4); }

  template <class Value>
  Json column(Value value) const {
    Json cells = Json::array();
    for (const TrackRow& row : c_.track) cells.push_back(value(row));
    return cells;
  }

  Json track() const {
    Json out = {{"t", column([&](const TrackRow& r) { return seconds(r.stamp); })},
                {"x", column([](const TrackRow& r) { return metres(r.T_map_base.p.x()); })},
                {"y", column([](const TrackRow& r) { return metres(r.T_map_base.p.y()); })},
                {"yaw", column([](const TrackRow& r) { return decimals(r.T_map_base.yaw() * kDegrees, 3); })},
                {"sx", column([](const TrackRow& r) { return digits(sigma_of(r.P(0, 0))); })},
                {"sy", column([](const TrackRow& r) { return digits(sigma_of(r.P(1, 1))); })},
                {"sxy", column([](const TrackRow& r) { return digits(r.P(0, 1)); })},
                {"syaw", column([](const TrackRow& r) { return digits(sigma_of(r.P(2, 2)) * kDegrees); })},
                {"n_eff", column([](const TrackRow& r) { return decimals(r.n_eff, 1); })}};
    if (!c_.is_spatial) return out;
    out["z"] = column([](const TrackRow& r) { return metres(r.T_map_base.p.z()); });
    out["sz"] = column([](const TrackRow& r) { return digits(r.sigma_z_m); });
    const auto angle = [](int axis) {
      return [axis](const TrackRow& r) { return decimals(so3::to_rpy(r.T_map_base.q)[axis] * kDegrees, 3); };
    };
    out["roll"] = column(angle(0));
    out["pitch"] = column(angle(1));
    out["sroll"] = column([](const TrackRow& r) { return digits(r.sigma_roll_rad * kDegrees); });
    out["spitch"] = column([](const TrackRow& r) { return digits(r.sigma_pitch_rad * kDegrees); });
    return out;
  }

  Json states() const {
    Json out = Json::array();
    for (std::size_t i = 0; i < c_.states.size(); ++i) {
      out.push_back({{"sensor", c_.states[i].sensor},
                     {"name", c_.states[i].name},
                     {"value", column([i](const TrackRow& r) { return digits(r.block[i]); })},
                     {"sigma", column([i](const TrackRow& r) { return digits(r.block_sigma[i]); })}});
    }
    return out;
  }

  /// The reference as a line, and where it is at the times of the track.
  Json reference() const {
    if (!c_.reference) return nullptr;
    const auto& points = c_.reference->trajectory;
    const run_views::ReferenceLookup lookup(*c_.reference);
    Json line = {{"x", Json::array()}, {"y", Json::array()}};
    const std::size_t stride = points.size() / kMostLinePoints + 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool is_kept = i % stride == 0 || i + 1 == points.size();
      if (is_kept) {
        line["x"].push_back(metres(points[i].T_map_base.p.x()));
        line["y"].push_back(metres(points[i].T_map_base.p.y()));
      }
      if (!lookup.is_pause(i)) continue;
      line["x"].push_back(nullptr);
      line["y"].push_back(nullptr);
    }
    Json landmarks = Json::array();
    for (const Reference::Landmark& landmark : c_.reference->landmarks)
      landmarks.push_back(
          {landmark.name, metres(landmark.p_map.x()), metres(landmark.p_map.y()), metres(landmark.radius_m)});
    Json out = {{"line", std::move(line)},
                {"landmarks", std::move(landmarks)},
                {"has_yaw", !points.empty() && std::ranges::all_of(points, &Reference::Point::has_yaw)},
                {"at_track", at_track(lookup)}};
    if (c_.reference_alignment) {
      const Pose& T = *c_.reference_alignment;
      out["alignment"] = {{"x", metres(T.p.x())}, {"y", metres(T.p.y())}, {"yaw", decimals(T.yaw() * kDegrees, 3)}};
    }
    return out;
  }

  Json at_track(const run_views::ReferenceLookup& lookup) const {
    std::vector<std::optional<Pose>> poses;
    for (const TrackRow& row : c_.track) poses.push_back(lookup.at(row.stamp));
    const auto of = [&](const auto& value) {
      Json cells = Json::array();
      for (const auto& pose : poses) cells.push_back(pose ? value(*pose) : Json(nullptr));
      return cells;
    };
    const auto angle = [](int axis) {
      return [axis](const Pose& T) { return decimals(so3::to_rpy(T.q)[axis] * kDegrees, 3); };
    };
    Json out = {{"x", of([](const Pose& T) { return metres(T.p.x()); })},
                {"y", of([](const Pose& T) { return metres(T.p.y()); })},
                {"yaw", of(angle(2))}};
    if (!c_.is_spatial) return out;
    out["z"] = of([](const Pose& T) { return metres(T.p.z()); });
    out["roll"] = of(angle(0));
    out["pitch"] = of(angle(1));
    return out;
  }

  Json fixes() const {
    Json out = Json::array();
    for (const Content::Fixes& fixes : c_.fixes) {
      Json x = Json::array();
      Json y = Json::array();
      for (const Eigen::Vector2d& p : fixes.positions) {
        x.push_back(metres(p.x()));
        y.push_back(metres(p.y()));
      }
      out.push_back({{"kind", fixes.kind}, {"count", fixes.count}, {"x", std::move(x)}, {"y", std::move(y)}});
    }
    return out;
  }

  Json outages() const {
    Json out = Json::array();
    for (const Content::SensorOutages& sensor : c_.outages) {
      for (const Outage& outage : sensor.outages)
        out.push_back({{"sensor", sensor.sensor}, {"from", seconds(outage.from)}, {"to", seconds(outage.to)}});
    }
    return out;
  }

  Json health() const {
    Json changes = Json::array();
    for (const auto& change : c_.health.changes()) {
      const Json sensor = change.sensor == run_views::HealthChanges::kPose ? Json(nullptr) : Json(change.sensor);
      changes.push_back({seconds(change.stamp), sensor, change.state, change.reason});
    }
    return {{"changes", std::move(changes)}, {"left_out", c_.health.left_out()}};
  }

  Json sensors() const {
    Json out = Json::array();
    for (const SensorReport& sensor : c_.run.sensors) {
      const SensorSummary summary = summarize(sensor);
      Json row = {{"name", summary.name},
                  {"plugin", summary.plugin},
                  {"rate_hz", digits(summary.rate_hz)},
                  {"measurements", summary.measurements},
                  {"used", summary.used},
                  {"rejected", summary.rejected},
                  {"nis", digits(summary.nis_ratio)},
                  {"nis_low", digits(summary.nis_low)},
                  {"nis_high", digits(summary.nis_high)},
                  {"verdict", summary.verdict}};
      // Why the rest was not used.
      Json others = Json::object();
      const auto other = [&](const char* name, std::uint64_t count) {
        if (count > 0) others[name] = count;
      };
      other("gated", sensor.gated);
      other("unusable", sensor.unusable);
      other("skipped by maps", sensor.skipped);
      other("held out", sensor.held_out);
      other("too late", sensor.late);
      other("before the start", sensor.before_start);
      other("ignored", sensor.ignored);
      other("wrong stamp", sensor.mistimed);
      row["others"] = std::move(others);
      out.push_back(std::move(row));
    }
    return out;
  }

  Json sensor_series() const {
    Json t = Json::array();
    for (const SensorSeries::Row& row : c_.sensor_series) t.push_back(seconds(row.stamp));
    Json all = Json::array();
    for (std::size_t i = 0; i < c_.run.sensors.size(); ++i) {
      Json one = {{"used", Json::array()}, {"rejected", Json::array()}, {"nis", Json::array()}, {"dof", Json::array()}};
      for (const SensorSeries::Row& row : c_.sensor_series) {
        const SensorSeries::Sums sums = i < row.sensors.size() ? row.sensors[i] : SensorSeries::Sums{};
        one["used"].push_back(sums.used);
        one["rejected"].push_back(sums.rejected);
        one["nis"].push_back(decimals(sums.nis, 2));
        one["dof"].push_back(sums.nis_dof);
      }
      all.push_back(std::move(one));
    }
    return {{"t", std::move(t)}, {"sensors", std::move(all)}};
  }

  Json map() const {
    if (!c_.end) return nullptr;
    Json particles = Json::array();
    for (const ParticleView& particle : c_.end->particles)
      particles.push_back({metres(particle.T_map_base.p.x()), metres(particle.T_map_base.p.y())});
    Json modes = Json::array();
    ModeFinder finder;
    for (const PoseMode& mode : finder.find(c_.end->particles))
      modes.push_back({metres(mode.T_map_base.p.x()), metres(mode.T_map_base.p.y()), decimals(mode.weight, 3)});
    Json x = Json::array();
    Json y = Json::array();
    const auto& path = c_.end->best_path;
    const std::size_t stride = path.size() / kMostLinePoints + 1;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (i % stride != 0 && i + 1 != path.size()) continue;
      x.push_back(metres(path[i].T_map_base.p.x()));
      y.push_back(metres(path[i].T_map_base.p.y()));
    }
    Json maps = Json::array();
    for (const MapDescription& map : c_.end->maps) maps.push_back(describe(map));
    return {{"particles", std::move(particles)},
            {"modes", std::move(modes)},
            {"path", {{"x", std::move(x)}, {"y", std::move(y)}}},
            {"maps", std::move(maps)}};
  }

  static Json describe(const MapDescription& map) {
    Json landmarks = Json::array();
    for (const LandmarkView& l : map.landmarks) {
      landmarks.push_back({{"id", l.id},
                           {"x", metres(l.p_map.x())},
                           {"y", metres(l.p_map.y())},
                           {"r", metres(l.radius_m)},
                           {"P", {digits(l.P(0, 0)), digits(l.P(0, 1)), digits(l.P(1, 1))}},
                           {"existence", digits(l.existence)},
                           {"sightings", l.sightings},
                           {"confirmed", l.confirmed}});
    }
    Json figures = Json::array();
    for (const MapFigure& figure : map.figures) figures.push_back({figure.name, digits(figure.value)});
    Json out = {{"name", map.module}, {"landmarks", std::move(landmarks)}, {"figures", std::move(figures)}};
    if (map.grid && map.grid->width > 0 && map.grid->height > 0) {
      const GridImage image = picture_of(*map.grid);
      const Pose& T = map.grid->T_map_grid;
      out["grid"] = {{"png", image.png_base64},
                     {"x", metres(T.p.x())},
                     {"y", metres(T.p.y())},
                     {"yaw", decimals(T.yaw(), 6)},
                     {"width_m", image.width_m},
                     {"height_m", image.height_m},
                     {"resolution_m", map.grid->resolution_m}};
    }
    return out;
  }

  Json events() const {
    Json out = Json::array();
    const auto& events = c_.run.events;
    for (std::size_t i = 0; i < std::min(events.size(), kMostTexts); ++i)
      out.push_back({{"t", seconds(events[i].stamp)}, {"text", events[i].text}, {"failure", events[i].is_failure}});
    return {{"count", events.size()}, {"first", std::move(out)}};
  }

  Json findings() const {
    Json out = Json::array();
    for (const Finding& finding : c_.run.findings) {
      out.push_back({{"t", seconds(finding.stamp)},
                     {"certainty", to_string(finding.certainty)},
                     {"sensors", finding.sensors},
                     {"text", finding.seen},
                     {"suggestion", finding.change},
                     {"sigmas", digits(finding.sigmas)}});
    }
    return out;
  }

  static Json texts(const std::vector<std::string>& all) {
    return std::vector<std::string>(all.begin(),
                                    all.begin() + static_cast<std::ptrdiff_t>(std::min(all.size(), kMostTexts)));
  }

  Json bad_records() const {
    Json out = Json::array();
    constexpr std::size_t kShown = 20;
    const auto& records = c_.run.bad_records;
    for (std::size_t i = 0; i < std::min(records.size(), kShown); ++i)
      out.push_back({records[i].place, records[i].reason});
    return {{"count", records.size()}, {"first", std::move(out)}};
  }

  static Json live(const LiveReport& live) {
    Json streams = Json::array();
    for (const LiveReport::Stream& s : live.streams) {
      streams.push_back({{"sensor", s.sensor},
                         {"received", s.received},
                         {"dropped", s.dropped},
                         {"missing", s.missing},
                         {"latency_median_s", digits(s.latency_s.median)},
                         {"latency_p99_s", digits(s.latency_s.p99)}});
    }
    return {{"cpu_share", digits(live.cpu_share)}, {"streams", std::move(streams)}};
  }

  const Content& c_;
};

}  // namespace

std::string to_json(const Content& content) {
  // A bad record may quote bytes of the log that are not UTF-8.
  const std::string text = Document(content).whole().dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  // Only inside of strings: "</script>" would end the element that holds the document.
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

}  // namespace waymark::report
