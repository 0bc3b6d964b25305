// SPDX-License-Identifier: Apache-2.0
// A raw recording of KITTI; the first byte of an input says which of its files the rest is.
#include <array>
#include <string>

#include "input.hpp"
#include "source.hpp"

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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  static const Pose kLidar{Eigen::Quaterniond::Identity(), {1.0, 0.0, 1.5}};
  static const Rig kRig({{"lidar", "waymark/LaserScan@1", kLidar},
                         {"camera", "waymark/Image@1", Pose{Eigen::Quaterniond::Identity(), {1.3, 0.2, 1.3}},
                          Intrinsics{640, 480, 700.0, 700.0, 320.0, 240.0, {}}}});
  const fuzz::Choice choice = fuzz::choose(fuzz::text_of(data, size), kFiles.size());
  for (std::size_t i = 0; i < kFiles.size(); ++i) {
    if (i != kGzip || choice.which == kGzip)
      fuzz::write(kFiles[i].name, i == choice.which ? choice.rest : kFiles[i].content);
  }
  fuzz::read_source(
      "folder: log\nmax_bad_records: 100\nlidar: { sensor: lidar, height_m: [1, 2] }\n"
      "camera: { sensor: camera, stamp: own }\n",
      kRig);
  std::filesystem::remove(fuzz::folder() / kFiles[kGzip].name);
  return 0;
}
