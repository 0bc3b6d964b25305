// SPDX-License-Identifier: Apache-2.0
// needs plugins: diagnostics, geo_track, grid_map, held_out, json_poses, landmarks, log, map_files, plot, pose_csv
// needs plugins: recorder, tum
#include <gtest/gtest.h>

#include <ostream>

#include "our_plugins.hpp"
#include "waymark/testing/sink_contract.hpp"

namespace waymark::contract_test {
namespace {

struct Case {
  const char* plugin;
  const char* yaml;
};

void PrintTo(const Case& one, std::ostream* out) { *out << one.plugin << " " << one.yaml; }

class OurSinks : public ::testing::TestWithParam<Case> {};

TEST_P(OurSinks, KeepTheContract) {
  const auto make = [](const Config& config, const Rig& rig) {
    return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sink>(GetParam().plugin, config, rig);
  };
  testing::SinkSetting setting;
  setting.run_config =
      "source: { plugin: scripted }\ndatum: { latitude_deg: 49, longitude_deg: 8 }\n"
      "sensors: [{ name: wheels }, { name: gps }, { name: lidar }, { name: other }]\n";
  EXPECT_EQ(testing::to_text(testing::check_sink(make, GetParam().yaml, setting)), "");
}

INSTANTIATE_TEST_SUITE_P(
    All, OurSinks,
    ::testing::Values(Case{"diagnostics", "{ file: d.json, map_figures_file: m.csv, map_figures_every_s: 1 }"},
                      Case{"diagnostics", "{}"}, Case{"geo_track", "{}"},
                      Case{"geo_track", "{ gpx: none, kml: a.kml, geojson: a.geojson, every_s: 0 }"},
                      Case{"grid_map", "{}"}, Case{"held_out", "{ file: h.csv }"},
                      Case{"json_poses", "{ to: file, file: p.jsonl, when: committed, payload: pose }"},
                      Case{"json_poses", "{ to: file, payload: BodyTwist, sensor: wheels }"},
                      Case{"json_poses", "{ to: file, when: front }"},
                      Case{"landmarks", "{ file: l.csv, reference_file: r.csv, confirmed_only: false }"},
                      Case{"log", "{ folder: log, png_compression: 1, leave_out: [other] }"}, Case{"map_files", "{}"},
                      Case{"plot", "{ file: map.png, width_px: 480, height_px: 360, disagreement: true }"},
                      Case{"pose_csv", "{ file: p.csv, every_s: 0.3 }"},
                      Case{"recorder", "{ file: f.mcap, compression: zstd, flush_s: 1, queue_mb: 4, maps: true }"},
                      Case{"tum", "{ trajectory: t.txt, path: p.txt, reference: r.txt, covariance: c.csv }"}));

}  // namespace
}  // namespace waymark::contract_test
