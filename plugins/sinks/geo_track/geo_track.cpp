// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "track.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::geo_track {
namespace {

/// Empty for `none`.
std::string file_of(const Config& config, const Config::Key& key, std::string_view fallback) {
  if (!config.is_word(key, "none")) return config.output(key, fallback);
  config.text(key);
  return {};
}

/// The path and the landmarks on the Earth, for maps and navigation programs.
class GeoTrack : public Sink {
 public:
  explicit GeoTrack(const Config& config)
      : gpx_(file_of(config, {"gpx", "file name in the output folder; `none`: it is not written"}, "track.gpx")),
        kml_(file_of(config, {"kml", "file name in the output folder; `none`: it is not written"}, "track.kml")),
        geojson_(
            file_of(config, {"geojson", "file name in the output folder; `none`: it is not written"}, "track.geojson")),
        path_(from_seconds(config.non_negative({"every_s", "s", "time between two points of the track"}, 1.0))) {}

  void start(const RunInfo& info) override {
    out_dir_ = info.out_dir;
    // The absolute path of a folder such as `out/run/`.
    const std::filesystem::path folder = std::filesystem::absolute(out_dir_).lexically_normal();
    name_ = folder.has_filename() ? folder.filename().string() : folder.parent_path().filename().string();
  }

  void write(const Snapshot& snapshot) override {
    if (!snapshot.started()) {
      path_.interrupt();
    } else {
      path_.add(snapshot.stamp(), snapshot.belief().mean.T_map_base.p);
    }
  }

  void finish(const Snapshot* last, const RunReport&) override {
    if (last == nullptr || !last->started()) return;
    if (!last->datum()) {
      throw Error(
          "the map has no place on the Earth: no geodetic fix arrived, and the YAML has no `datum`; nothing is "
          "written");
    }
    Track track{name_, path_.pieces(*last->datum()), marks_of(*last)};
    for (const auto& [file, write_as] :
         {std::pair(&gpx_, &to_gpx), std::pair(&kml_, &to_kml), std::pair(&geojson_, &to_geojson)}) {
      if (!file->empty()) write_file(out_dir_ / *file, write_as(track));
    }
  }

 private:
  static std::vector<Mark> marks_of(const Snapshot& last) {
    std::vector<Mark> marks;
    std::vector<Eigen::Vector3d> positions;
    for (const MapDescription& map : last.best_maps(MapDetail::summary)) {
      for (const LandmarkView& landmark : map.landmarks) {
        if (!landmark.confirmed) continue;
        marks.push_back({fmt::format("{} {}", map.module, landmark.id), {}});
        positions.emplace_back(landmark.p_map.x(), landmark.p_map.y(), 0.0);
      }
    }
    const std::vector<Place> on_earth = places(positions, *last.datum());
    for (std::size_t i = 0; i < marks.size(); ++i) marks[i].place = on_earth[i];
    return marks;
  }

  std::string gpx_;
  std::string kml_;
  std::string geojson_;
  ThinnedPath path_;
  std::filesystem::path out_dir_;
  std::string name_;
};

}  // namespace
}  // namespace waymark::geo_track

WAYMARK_PLUGIN(waymark::Sink, waymark::geo_track::GeoTrack, "geo_track", "1.0.0")
