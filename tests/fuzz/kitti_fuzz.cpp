// SPDX-License-Identifier: Apache-2.0
// A raw recording of KITTI; the first byte of an input says which of its files the rest is.
#include <array>
#include <string>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_kitti;

namespace waymark::fuzz::kitti_harness {
namespace {
struct File {
  const char* name;
  std::string_view content;
};

constexpr std::string_view kPoints("\0\0\x80\x3f\0\0\x80\x3f\0\0\0\0\0\0\0\x3f", 16);  // (1, 1, 0) m
constexpr std::string_view kStamps =
    "2011-09-26 13:02:25.951199337\n2011-09-26 13:02:26.054912121\n2011-09-26 13:02:26.158239313\n";
constexpr std::array kFiles{
    File{"log/velodyne_points/data/0000000000.bin", kPoints},
    File{"log/velodyne_points/timestamps.txt", kStamps},
    File{"log/calib/calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0.1 -0.2 -0.3\n"},
    File{"log/calib/calib_cam_to_cam.txt",
         "R_rect_00: 1 0 0 0 1 0 0 0 1\nS_rect_02: 640 480\nP_rect_02: 700 0 320 70 0 700 240 0 0 0 1 0\n"},
    File{"log/image_02/data/0000000000.png", "picture"},
    File{"log/image_02/timestamps.txt", kStamps},
    // gzip, a file of its own frame
    File{"log/velodyne_points/data/0000000001.bin.gz", {}},
};
constexpr std::size_t kGzip = kFiles.size() - 1;

void run(std::string_view input) {
  static const Pose kLidar{Eigen::Quaterniond::Identity(), {1.0, 0.0, 1.5}};
  static const Rig kRig({{"lidar", "waymark/LaserScan@1", kLidar},
                         {"camera", "waymark/Image@1", Pose{Eigen::Quaterniond::Identity(), {1.3, 0.2, 1.3}},
                          Intrinsics{640, 480, 700.0, 700.0, 320.0, 240.0, {}}}});
  const Choice choice = choose(input, kFiles.size());
  for (std::size_t i = 0; i < kFiles.size(); ++i) {
    if (i != kGzip || choice.which == kGzip) write(kFiles[i].name, i == choice.which ? choice.rest : kFiles[i].content);
  }
  read_source(waymark_plugin_kitti,
              "folder: log\nmax_bad_records: 100\nlidar: { sensor: lidar, height_m: [1, 2] }\n"
              "camera: { sensor: camera, stamp: own }\n",
              kRig);
  static const Rig kCloudRig({{"lidar", "waymark/PointCloud@1", kLidar}});
  read_source(waymark_plugin_kitti,
              "folder: log\nmax_bad_records: 100\nlidar: { sensor: lidar, payload: PointCloud, every_nth_point: 2 }\n",
              kCloudRig);
  std::filesystem::remove(folder() / kFiles[kGzip].name);
}

const Harness kHarness("kitti", run);

}  // namespace
}  // namespace waymark::fuzz::kitti_harness
