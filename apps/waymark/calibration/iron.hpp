// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace waymark::calibration {

/// What a robot does to the Earth's field, so that soft (m − hard) has one strength in all attitudes of the log.
struct Iron {
  int axes = 0;  ///< 3: all; 2: x and y alone, z was not excited
  Eigen::Vector3d hard = Eigen::Vector3d::Zero();
  Eigen::Vector3d hard_sigma = Eigen::Vector3d::Zero();
  /// Symmetric, of determinant 1: a rotation is the mounting's, and the strength of the Earth's field is not known.
  Eigen::Matrix3d soft = Eigen::Matrix3d::Identity();
  double soft_sigma = 0.0;  ///< the largest one of its elements
  double strength = 0.0;    ///< of the field in these axes, afterwards [the unit of the readings]
  double scatter = 0.0;     ///< r.m.s. of its strength afterwards, as a share
  double gap_rad = 0.0;     ///< `axes` 2: the widest sector of directions without a reading
};

/// An ellipsoid through the readings of a magnetometer (or an ellipse, where the robot stays level): its centre is the
/// hard iron, its shape the soft iron. Least squares of the squared distance to first order (P. D. Sampson, Computer
/// Graphics and Image Processing 18, 1982), from the algebraic fit on, with Huber's weights. σ is the larger one of the
/// usual one and of the scatter of the scores over twenty blocks of time. `fields`: in the axes of the base, z up, in
/// order of time. Nothing if there are fewer than 50, or they lie on no ellipse.
std::optional<Iron> fit_iron(const std::vector<Eigen::Vector3d>& fields);

}  // namespace waymark::calibration
