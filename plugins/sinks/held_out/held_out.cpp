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

constexpr int kDecimals = 6;
constexpr int kDegreeDecimals = 10;  // 0.01 mm

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
    // A geodetic fix stays geodetic: the datum belongs to the filter.
    const bool local = std::isfinite(p.x()) && std::isfinite(p.y());
    const std::string position =
        local ? fmt::format("{},{},{},,,", csv_field(p.x(), kDecimals), csv_field(p.y(), kDecimals),
                            csv_field(p.z(), kDecimals))
              : fmt::format(",,,{},{},{}", csv_field(fix.latitude_deg, kDegreeDecimals),
                            csv_field(fix.longitude_deg, kDegreeDecimals), csv_field(fix.height_m, kDecimals));
    file_->write(fmt::format("{},{},{}\n", format_time(measurement.stamp), sensor_name(measurement.sensor), position));
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
