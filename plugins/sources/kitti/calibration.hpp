// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"

namespace waymark::kitti {

/// The recording's calibration of its scanner and one of its rectified cameras.
struct Calibration {
  Pose T_lidar_camera;  ///< both with x forward, y left, z up
  Intrinsics intrinsics;
};

/// Reads `calib_cam_to_cam.txt` and `calib_velo_to_cam.txt`. A pixel is P_rect_i · R_rect_00 · (R|T) · point. Throws
/// DataError, which names the file, if they cannot be read or lack a key.
Calibration read_calibration(const std::filesystem::path& folder, int camera);

/// Throws ConfigError if the camera of the YAML is mounted elsewhere (by more than 5 mm or 0.05°) or has other
/// intrinsics (by more than 0.1 px) than the recording has, or lacks either; the text holds the lines that are right
/// for the YAML's scanner.
void check_calibration(const Calibration& calibration, const Pose& T_base_lidar, const Mounting& camera,
                       const Config& config);

}  // namespace waymark::kitti
