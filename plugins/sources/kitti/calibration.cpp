// SPDX-License-Identifier: Apache-2.0
#include "calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "planar_cut.hpp"
#include "waymark/base/error.hpp"

namespace waymark::kitti {
namespace {

/// A file of lines "name: number number …".
class NamedNumbers {
 public:
  explicit NamedNumbers(const std::filesystem::path& file) : file_(file) {
    std::ifstream in(file);
    if (!in) throw DataError(file.string() + ": cannot be read");
    for (std::string line; std::getline(in, line);) {
      const std::size_t colon = line.find(':');
      if (colon == std::string::npos) continue;
      std::istringstream rest(line.substr(colon + 1));
      std::vector<double>& values = values_[line.substr(0, colon)];
      for (double value = 0.0; rest >> value;) values.push_back(value);
    }
  }

  /// The numbers of one line as a matrix, row by row.
  template <int R, int C>
  Eigen::Matrix<double, R, C> matrix(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end() || found->second.size() != R * C ||
        !std::ranges::all_of(found->second, [](double v) { return std::isfinite(v); })) {
      throw DataError(fmt::format("{}: a line \"{}:\" with {} numbers is expected", file_.string(), name, R * C));
    }
    Eigen::Matrix<double, R, C> m;
    for (int i = 0; i < R * C; ++i) m(i / C, i % C) = found->second[static_cast<std::size_t>(i)];
    return m;
  }

 private:
  std::filesystem::path file_;
  std::map<std::string, std::vector<double>> values_;
};

/// Rotations come with seven digits.
Eigen::Quaterniond rotation(const Eigen::Matrix3d& R, const std::filesystem::path& file) {
  constexpr double kLoose = 1e-4;
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > kLoose || R.determinant() < 0.0)
    throw DataError(file.string() + ": a rotation matrix is not orthonormal");
  return Eigen::Quaterniond(R).normalized();
}

std::string numbers(std::initializer_list<double> values, int digits) {
  std::string text;
  for (const double value : values) {
    std::string one = fmt::format("{:.{}f}", value, digits);
    if (one.find_first_not_of("-0.") == std::string::npos) one = "0";
    text += (text.empty() ? "" : ", ") + one;
  }
  return text;
}

std::string yaml_of(const Pose& T_base_camera, const Intrinsics& in) {
  const Eigen::Vector3d rpy = so3::to_rpy(T_base_camera.q) / kDegree;
  const Eigen::Vector3d& p = T_base_camera.p;
  return fmt::format(
      "base_T_sensor: {{ xyz_m: [{}], roll_deg: {}, pitch_deg: {}, yaw_deg: {} }}, "
      "intrinsics: {{ size_px: [{}, {}], focal_px: [{}], center_px: [{}] }}",
      numbers({p.x(), p.y(), p.z()}, 4), numbers({rpy.x()}, 4), numbers({rpy.y()}, 4), numbers({rpy.z()}, 4), in.width,
      in.height, numbers({in.fx, in.fy}, 4), numbers({in.cx, in.cy}, 4));
}

/// How two cameras differ, in words; empty if they agree.
std::string difference(const Intrinsics& given, const Intrinsics& right) {
  constexpr double kPixels = 0.1;
  const auto apart = [&](double a, double b) { return !(std::abs(a - b) <= kPixels); };
  if (given.width != right.width || given.height != right.height) return "another size";
  if (apart(given.fx, right.fx) || apart(given.fy, right.fy)) return "another focal length";
  if (apart(given.cx, right.cx) || apart(given.cy, right.cy)) return "another centre";
  if (std::ranges::any_of(given.distortion, [](double k) { return k != 0.0; }))
    return "a distortion, but the images are rectified";
  return {};
}

}  // namespace

Calibration read_calibration(const std::filesystem::path& folder, int camera) {
  const std::filesystem::path cameras_file = folder / "calib_cam_to_cam.txt";
  const std::filesystem::path lidar_file = folder / "calib_velo_to_cam.txt";
  const NamedNumbers cameras(cameras_file);
  const NamedNumbers lidar(lidar_file);
  const auto of_camera = [&](const char* name) { return fmt::format("{}_{:02}", name, camera); };

  const auto P = cameras.matrix<3, 4>(of_camera("P_rect"));
  const auto size = cameras.matrix<1, 2>(of_camera("S_rect"));
  if (!(P(0, 0) > 0.0) || !(P(1, 1) > 0.0) || !(size.minCoeff() > 0.0))
    throw DataError(fmt::format("{}: {} or {} is not valid for a camera", cameras_file.string(), of_camera("P_rect"),
                                of_camera("S_rect")));
  Calibration calibration;
  Intrinsics& in = calibration.intrinsics;
  in.width = static_cast<int>(std::lround(size(0)));
  in.height = static_cast<int>(std::lround(size(1)));
  in.fx = P(0, 0);
  in.fy = P(1, 1);
  in.cx = P(0, 2);
  in.cy = P(1, 2);

  // From the scanner to camera 0, its rectified frame, and along the baseline (P = K (I | t)) to the camera asked for.
  const Pose T_camera0_lidar{rotation(lidar.matrix<3, 3>("R"), lidar_file), lidar.matrix<3, 1>("T")};
  const Pose T_rectified_camera0{rotation(cameras.matrix<3, 3>("R_rect_00"), cameras_file), Eigen::Vector3d::Zero()};
  const Eigen::Matrix3d K = P.leftCols<3>();
  const Pose T_optical_rectified{Eigen::Quaterniond::Identity(), K.inverse() * P.col(3)};
  // An optical frame has z forward, x to the right, y down.
  Eigen::Matrix3d R_camera_optical;
  R_camera_optical << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  const Pose T_camera_optical{Eigen::Quaterniond(R_camera_optical), Eigen::Vector3d::Zero()};
  calibration.T_lidar_camera =
      (T_camera_optical * T_optical_rectified * T_rectified_camera0 * T_camera0_lidar).inverse();
  return calibration;
}

void check_calibration(const Calibration& calibration, const Pose& T_base_lidar, const Mounting& camera,
                       const Config& config) {
  constexpr double kDistance = 0.005;
  constexpr double kAngle = 0.05 * kDegree;
  const Pose right = T_base_lidar * calibration.T_lidar_camera;
  std::string wrong;
  if (!camera.T_base_sensor) {
    wrong = "it has no base_T_sensor";
  } else {
    const double distance = (camera.T_base_sensor->p - right.p).norm();
    const double angle = so3::log(camera.T_base_sensor->q.conjugate() * right.q).norm();
    if (!(distance <= kDistance) || !(angle <= kAngle))
      wrong = fmt::format("its base_T_sensor is {:.3f} m and {:.2f} deg off", distance, angle / kDegree);
  }
  if (!camera.intrinsics) {
    wrong += wrong.empty() ? "it has no intrinsics" : " and no intrinsics";
  } else if (const std::string differs = difference(*camera.intrinsics, calibration.intrinsics); !differs.empty()) {
    wrong += (wrong.empty() ? "its intrinsics have " : " and its intrinsics have ") + differs;
  }
  if (wrong.empty()) return;
  config.fail("sensor", fmt::format("sensors.{} does not fit the calibration of the recording: {}; right are {}",
                                    camera.name, wrong, yaml_of(right, calibration.intrinsics)));
}

}  // namespace waymark::kitti
