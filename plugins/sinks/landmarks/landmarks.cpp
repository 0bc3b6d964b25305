// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "waymark/io/csv_field.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::landmarks {
namespace {

constexpr std::string_view kHeader =
    "map,id,east_m,north_m,radius_m,var_east_m2,var_north_m2,cov_east_north_m2,var_radius_m2,existence,sightings,"
    "confirmed,conditional_var_east_m2,conditional_var_north_m2,conditional_cov_east_north_m2\n";
constexpr std::string_view kReferenceHeader = "name,x_m,y_m,radius_m\n";

constexpr int kDecimals = 6;
/// An unknown number is an empty field.
std::string squared(double value) { return std::isfinite(value) ? fmt::format("{:.6e}", value) : std::string(); }

std::string row(std::string_view map, const LandmarkView& landmark) {
  const bool has_radius = std::isfinite(landmark.radius_m);
  return fmt::format("{},{},{},{},{},{},{},{},{},{:.6f},{},{:d},{},{},{}\n", csv_field(map), landmark.id,
                     csv_field(landmark.p_map.x(), kDecimals), csv_field(landmark.p_map.y(), kDecimals),
                     csv_field(landmark.radius_m, kDecimals), squared(landmark.P(0, 0)), squared(landmark.P(1, 1)),
                     squared(landmark.P(0, 1)), has_radius ? squared(landmark.P(2, 2)) : std::string(),
                     landmark.existence, landmark.sightings, landmark.confirmed, squared(landmark.P_conditional(0, 0)),
                     squared(landmark.P_conditional(1, 1)), squared(landmark.P_conditional(0, 1)));
}

/// The landmarks of the best particle's maps as CSV, at the end of the run.
class Landmarks : public Sink {
 public:
  explicit Landmarks(const Config& config)
      : name_(config.output({"file", "file name in the output folder"}, "landmarks.csv")),
        reference_name_(config.output({"reference_file", "file name of the true landmarks in the output folder"},
                                      "reference_landmarks.csv")),
        confirmed_only_(config.boolean({"confirmed_only", "leave provisional landmarks out"}, true)) {}

  void start(const RunInfo& info) override {
    out_dir_ = info.out_dir;
    if (!info.reference || info.reference->landmarks.empty()) return;
    std::string text(kReferenceHeader);
    for (const Reference::Landmark& landmark : info.reference->landmarks) {
      text += fmt::format("{},{},{},{}\n", csv_field(landmark.name), csv_field(landmark.p_map.x(), kDecimals),
                          csv_field(landmark.p_map.y(), kDecimals), csv_field(landmark.radius_m, kDecimals));
    }
    write_file(out_dir_ / reference_name_, text);
  }

  void write(const Snapshot&) override {}

  void finish(const Snapshot* last, const RunReport&) override {
    std::string text(kHeader);
    if (last != nullptr && last->started()) {
      for (const MapDescription& map : last->best_maps(MapDetail::summary)) {
        for (const LandmarkView& landmark : map.landmarks) {
          if (landmark.confirmed || !confirmed_only_) text += row(map.module, landmark);
        }
      }
    }
    write_file(out_dir_ / name_, text);
  }

 private:
  std::string name_;
  std::string reference_name_;
  bool confirmed_only_;
  std::filesystem::path out_dir_;
};

}  // namespace
}  // namespace waymark::landmarks

WAYMARK_PLUGIN(waymark::Sink, waymark::landmarks::Landmarks, "landmarks", "1.0.0")
