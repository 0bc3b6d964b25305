// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "content.hpp"
#include "page.hpp"
#include "plugins/shared/run_views/fix_track.hpp"
#include "plugins/shared/run_views/reference_frame.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::report {
namespace {

const char* name_of(run_views::FixTrack::Kind kind) {
  switch (kind) {
    case run_views::FixTrack::Kind::used:
      return "used";
    case run_views::FixTrack::Kind::rejected:
      return "rejected";
    default:
      return "held out";
  }
}

/// The run as one page for a browser.
class Report : public Sink {
 public:
  explicit Report(const Config& config)
      : file_(config.output({"file", "file name in the output folder, ends in `.html`"}, "report.html")) {
    if (file_.extension() != ".html") config.fail("file", "\"" + file_.string() + "\" does not end in .html");
  }

  void start(const RunInfo& info) override {
    path_ = info.out_dir / file_;
    reference_ = info.reference;
    content_.name = info.name;
    content_.config = info.config;
  }

  void write(const Snapshot& snapshot) override {
    const Measurement& measurement = snapshot.measurement();
    if (!any_) content_.first = content_.last = measurement.stamp;
    any_ = true;
    if (snapshot.fate() != Fate::mistimed) {
      content_.first = std::min(content_.first, measurement.stamp);
      content_.last = std::max(content_.last, measurement.stamp);
    }
    fixes_.add(snapshot);
    has_started_ = has_started_ || snapshot.started();
    if (!has_started_) return;
    content_.health.add(snapshot.stamp(), snapshot.health());
    series_.add(snapshot);
    if (!snapshot.started()) return;  // the pose is lost
    track_.add(snapshot);
    if (snapshot.fate() == Fate::fused && measurement.payload->type() == GnssFix::kType)
      outages_[measurement.sensor].used(measurement.stamp);
  }

  void finish(const Snapshot* last, const RunReport& report) override {
    content_.run = report;
    if (last != nullptr && last->started()) {
      track_.add_last(*last);
      series_.finish(last->stamp());
      content_.end = Content::End{last->particles(), last->best_path(), last->best_maps(MapDetail::with_grids)};
      describe_states(last->layout());
    }
    content_.track = track_.rows();
    content_.sensor_series = series_.rows();
    take_reference();
    for (const auto kind : run_views::FixTrack::kKinds) {
      content_.fixes.push_back({name_of(kind), fixes_.count(kind),
                                fixes_.positions(kind, last != nullptr ? last->datum() : std::optional<Datum>())});
    }
    for (const auto& [sensor, log] : outages_) {
      const std::string name = sensor < report.sensors.size() ? report.sensors[sensor].name : std::to_string(sensor);
      content_.outages.push_back({name, log.outages(content_.last)});
    }
    write_page();
  }

 private:
  void describe_states(const StateLayout& layout) {
    content_.is_spatial = layout.motion() == StateLayout::Motion::spatial;
    for (const StateLayout::Owner& owner : layout.owners()) {
      for (const BlockState& state : owner.block) content_.states.push_back({owner.name, state.name});
    }
  }

  void take_reference() {
    if (reference_ == nullptr) return;
    std::vector<run_views::Estimate> estimates;
    for (const TrackRow& row : content_.track) {
      estimates.push_back({row.stamp, row.T_map_base, std::sqrt(std::max(row.P(0, 0), row.P(1, 1))),
                           std::sqrt(std::max(row.P(2, 2), 0.0))});
    }
    const run_views::ReferenceFrame frame = run_views::frame_of(*reference_, estimates);
    content_.reference = run_views::in_map(reference_, frame);
    if (frame.is_aligned) content_.reference_alignment = frame.T_map_reference;
  }

  void write_page() const {
    const Page around = page();
    OutputFile file(path_);
    for (const std::string_view part : around.before_data) file.write(part);
    file.write(to_json(content_));
    for (const std::string_view part : around.after_data) file.write(part);
    file.commit();
  }

  std::filesystem::path file_;
  std::filesystem::path path_;
  std::shared_ptr<const Reference> reference_;
  run_views::FixTrack fixes_;
  Track track_;
  SensorSeries series_;
  std::map<std::uint32_t, OutageLog> outages_;  // by index of the sensor
  bool any_ = false;
  bool has_started_ = false;
  Content content_;
};

}  // namespace
}  // namespace waymark::report

WAYMARK_PLUGIN(waymark::Sink, waymark::report::Report, "report", "1.0.0")
