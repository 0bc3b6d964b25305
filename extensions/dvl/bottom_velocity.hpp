// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string_view>

#include "waymark/interface/measurement.hpp"

namespace waymark::dvl {

/// Velocity over ground in the instrument's axes, as a Doppler log (DVL), a speed log or an optical flow sensor has it.
/// `BodyTwist@1` is planar, and needs a rate of rotation.
struct BottomVelocity : PayloadOf<BottomVelocity> {
  static constexpr std::string_view kType = "dvl/BottomVelocity@1";
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  Eigen::Vector3d v_mps = Eigen::Vector3d::Constant(kUnknown);
  Eigen::Vector3d variance_m2ps2 = Eigen::Vector3d::Constant(kUnknown);
  double altitude_m = kUnknown;
  bool locked = true;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&BottomVelocity::v_mps, {.names = {"v_x_mps", "v_y_mps", "v_z_mps"},
                                   .unit = "m/s",
                                   .meaning = "velocity over ground; a log of one axis leaves the others unknown",
                                   .required = false,
                                   .unknown = "NaN",
                                   .separable = true});
    field(&BottomVelocity::variance_m2ps2, {.names = {"variance_x_m2ps2", "variance_y_m2ps2", "variance_z_m2ps2"},
                                            .unit = "m²/s²",
                                            .meaning = "its variance, as the device reports it",
                                            .required = false,
                                            .unknown = "NaN",
                                            .separable = true});
    field(&BottomVelocity::altitude_m, {.names = {"altitude_m"},
                                        .unit = "m",
                                        .meaning = "distance to the ground along the instrument",
                                        .required = false,
                                        .unknown = "NaN"});
    field(&BottomVelocity::locked, {.names = {"locked"},
                                    .meaning = "false: the beams have no ground; the velocity is not known",
                                    .required = false});
  }
};

}  // namespace waymark::dvl
