// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <string_view>

#include "waymark/interface/measurement.hpp"

namespace waymark::relative {

/// The motion of a camera or a LIDAR over an interval that begins at the stamp, as its odometry has it.
/// `PoseIncrement@1` is planar, and has neither covariance nor track.
struct RelativePose : PayloadOf<RelativePose> {
  static constexpr std::string_view kType = "odometry/RelativePose@1";
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  double interval_s = 0.0;
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d sigma_p_m{kUnknown, kUnknown, kUnknown};
  Eigen::Vector3d sigma_q_rad{kUnknown, kUnknown, kUnknown};
  bool tracked = true;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&RelativePose::interval_s,
          {.names = {"interval_s"}, .unit = "s", .meaning = "length of the interval, more than 0"});
    field(&RelativePose::p_m, {.names = {"x_m", "y_m", "z_m"},
                               .unit = "m",
                               .meaning = "position at the end of the interval, in the sensor's frame at its begin"});
    field(&RelativePose::q, {.names = {"q_w", "q_x", "q_y", "q_z"}, .meaning = "orientation, likewise"});
    field(&RelativePose::sigma_p_m, {.names = {"sigma_x_m", "sigma_y_m", "sigma_z_m"},
                                     .unit = "m",
                                     .meaning = "σ of the position",
                                     .required = false,
                                     .unknown = "NaN"});
    field(&RelativePose::sigma_q_rad, {.names = {"sigma_roll_rad", "sigma_pitch_rad", "sigma_yaw_rad"},
                                       .unit = "rad",
                                       .meaning = "σ of the rotation about the sensor's axes",
                                       .required = false,
                                       .unknown = "NaN"});
    field(&RelativePose::tracked,
          {.names = {"tracked"},
           .meaning = "false: the track was lost, or the odometry's frame began anew; the motion is not known",
           .required = false});
  }
  std::string_view contradiction() const {
    if (!(interval_s > 0.0)) return "its interval is not positive";
    return std::abs(q.norm() - 1.0) < 1e-6 ? "" : "its orientation is no unit quaternion";
  }
};

}  // namespace waymark::relative
