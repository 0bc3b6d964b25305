// SPDX-License-Identifier: Apache-2.0
// Small files of clouds, written by the test.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::clouds_test {

template <class T>
std::string raw(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

using CompactPoint = std::array<std::int16_t, 3>;  // [2 mm]

inline std::string compact_head(std::uint32_t clouds) { return "PTS30001" + raw(clouds); }
inline std::string compact_cloud(double t_s, const std::vector<CompactPoint>& points) {
  std::string bytes = raw(t_s) + raw(static_cast<std::uint32_t>(points.size()));
  for (const CompactPoint& p : points) bytes += raw(p);
  return bytes;
}

inline std::string full_head(std::uint32_t clouds, std::uint32_t has = 0) {
  return "PTS30002" + raw(clouds) + raw(has);
}
/// The floats of all points, one after the other.
inline std::string full_cloud(std::int64_t t_ns, std::uint32_t points, const std::vector<float>& values) {
  std::string bytes = raw(t_ns) + raw(points);
  for (const float value : values) bytes += raw(value);
  return bytes;
}

/// `count` points at x = 0, 2, 4, … mm.
inline std::vector<CompactPoint> row_of(std::int16_t count) {
  std::vector<CompactPoint> points;
  for (std::int16_t i = 0; i < count; ++i) points.push_back({i, 0, 0});
  return points;
}

/// A folder with a file of clouds in it, and sources whose YAML lies beside it.
class CloudsTest : public ::testing::Test {
 protected:
  void write(std::string_view content, const std::string& name = "clouds.bin") const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  std::shared_ptr<Source> make(const std::string& more = "", const std::string& name = "clouds.bin") const {
    const std::string yaml = "{ file: " + name + ", sensor: lidar" + (more.empty() ? "" : ", " + more) + " }";
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    auto source = PluginLoader({WAYMARK_PLUGIN_DIR})
                      .create<Source>("clouds", config, Rig({{"lidar", "waymark/PointCloud@1", Pose{}}}));
    config.reject_unread();
    return source;
  }
  static std::vector<Measurement> read_all(Source& source) {
    std::vector<Measurement> all;
    while (auto measurement = source.next()) all.push_back(std::move(*measurement));
    return all;
  }

  test::TemporaryFolder folder_;
};

}  // namespace waymark::clouds_test
