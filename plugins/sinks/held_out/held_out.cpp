// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "waymark/interface/payloads.hpp"
#include "waymark/io/csv_field.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::held_out {
namespace {

constexpr std::string_view kHeader = "t_s,sensor,x_m,y_m,z_m,latitude_deg,longitude_deg,height_m\n";

std::string metres(double value) { return std::isfinite(value) ? fmt::format("{:.6f}", value) : std::string(); }
/// Ten decimals of a degree are 0.01 mm.
std::string degrees(double value) { return std::isfinite(value) ? fmt::format("{:.10f}", value) : std::string(); }

/// The GNSS fixes that the YAML keeps out of the filter, as CSV, for scoring.
class HeldOut : public Sink {
 public:
  explicit HeldOut(const Config& config)
      : name_(config.output({"file", "file name in the output folder"}, "held_out.csv")) {}

  void start(const RunInfo& info) override {
    path_ = info.out_dir / name_;
    if (info.rig == nullptr) return;
    for (const Mounting& mounting : info.rig->mountings()) sensors_.push_back(csv_field(mounting.name));
  }

  void write(const Snapshot& snapshot) override {
    const Measurement& measurement = snapshot.measurement();
    if (snapshot.fate() != Fate::held_out || measurement.payload->type() != GnssFix::kType) return;
    if (!file_) {
      file_.emplace(path_);
      file_->write(kHeader);
    }
    const auto& fix = measurement.as<GnssFix>();
    const Eigen::Vector3d& p = fix.p_map_antenna;
    // A geodetic fix stays geodetic: the datum is the filter's business.
    const bool local = std::isfinite(p.x()) && std::isfinite(p.y());
    file_->write(fmt::format("{},{},{},{},{},{},{},{}\n", format_time(measurement.stamp),
                             sensor_name(measurement.sensor), local ? metres(p.x()) : "", local ? metres(p.y()) : "",
                             local ? metres(p.z()) : "", local ? "" : degrees(fix.latitude_deg),
                             local ? "" : degrees(fix.longitude_deg), local ? "" : metres(fix.height_m)));
  }

  void finish(const Snapshot*, const RunReport&) override {
    if (file_) file_->commit();
  }

 private:
  std::string sensor_name(std::uint32_t index) const {
    return index < sensors_.size() ? sensors_[index] : std::to_string(index);
  }

  std::string name_;
  std::filesystem::path path_;
  std::vector<std::string> sensors_;  // names by index in the rig
  std::optional<OutputFile> file_;    // from the first fix on
};

}  // namespace
}  // namespace waymark::held_out

WAYMARK_PLUGIN(waymark::Sink, waymark::held_out::HeldOut, "held_out", "1.0.0")
