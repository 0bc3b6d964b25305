// SPDX-License-Identifier: Apache-2.0
// Small raw recordings of KITTI, written by the test.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::kitti_test {

using Point = std::array<float, 4>;  // x, y, z [m], reflectance

inline std::string bytes_of(const std::vector<Point>& points) {
  return {reinterpret_cast<const char*>(points.data()), points.size() * sizeof(Point)};
}

/// A camera 0.3 m before, 0.2 m to the left of and 0.2 m below the scanner, looking the same way, focal length 700 px:
/// P_rect_02 adds 70/700 m to x of T.
inline const std::string kLidarToCamera =
    "calib_time: 15-Mar-2012 11:37:16\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0.1 -0.2 -0.3\ndelta_f: 0 0\n";
inline const std::string kCameraToCamera =
    "corner_dist: 9.950000e-02\nR_rect_00: 1 0 0 0 1 0 0 0 1\nS_rect_02: 6.400000e+02 4.800000e+02\n"
    "P_rect_02: 7.0e+02 0 3.2e+02 7.0e+01 0 7.0e+02 2.4e+02 0 0 0 1 0\n";

/// A folder with a recording in `log`, and sources whose YAML lies beside it.
class KittiTest : public ::testing::Test {
 protected:
  void write(const std::string& name, std::string_view content) const {
    const std::filesystem::path file = folder_ / "log" / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << content;
  }
  static std::string cloud_file(int frame) { return fmt::format("velodyne_points/data/{:010}.bin", frame); }
  static std::string image_file(int frame) { return fmt::format("image_02/data/{:010}.png", frame); }
  void write_cloud(int frame, const std::vector<Point>& points) const { write(cloud_file(frame), bytes_of(points)); }
  void write_image(int frame, std::string_view content) const { write(image_file(frame), content); }
  void write_calibration() const {
    write("calib/calib_velo_to_cam.txt", kLidarToCamera);
    write("calib/calib_cam_to_cam.txt", kCameraToCamera);
  }

  std::shared_ptr<Source> make(const std::string& lidar_keys = "height_m: [1, 2]", const std::string& more = "") const {
    const std::string yaml = "folder: log\nlidar: { sensor: lidar, " + lidar_keys + " }\n" + more;
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("kitti", config, Rig({lidar_, camera_}));
    config.reject_unread();
    return source;
  }
  /// With the camera, whose calibration is not checked unless `keys` say so.
  std::shared_ptr<Source> make_with_camera(const std::string& keys = "calibration: none") const {
    return make("height_m: [1, 2]", "camera: { sensor: camera }\n" + keys + "\n");
  }

  static std::vector<Measurement> read_all(Source& source) {
    std::vector<Measurement> all;
    while (auto measurement = source.next()) all.push_back(std::move(*measurement));
    return all;
  }
  static std::vector<float> ranges_of(Source& source) {
    const auto measurement = source.next();
    if (measurement) return measurement->as<LaserScan>().ranges_m;
    ADD_FAILURE() << "no scan";
    return {};
  }

  test::TemporaryFolder folder_;
  Mounting lidar_{"lidar", "waymark/LaserScan@1", Pose{so3::from_rpy(0.0, 0.0, 0.0), {1.0, 0.0, 1.5}}};
  Mounting camera_{"camera", "waymark/Image@1", std::nullopt};
};

}  // namespace waymark::kitti_test
