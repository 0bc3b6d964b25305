// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "waymark/interface/measurement.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::relative {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Mean velocity and rate of the base over an interval: (v, ω), in its own axes.
struct Twist {
  Vector6 mean = Vector6::Zero();        ///< [m/s, rad/s]
  Matrix6 covariance = Matrix6::Zero();  ///< of the mean
  double interval_s = 0.0;
  bool tracked = true;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(mean, covariance, interval_s, tracked);
  }
};

/// Noise of an increment whose source gives none: σ² = density² · interval.
struct IncrementNoise {
  double position;    ///< [m/√s]
  double rotation;    ///< [rad/√s]
  bool use_reported;  ///< the source's own σ, where it gives one
};

/// The twist that a `RelativePose@1` or a `PoseIncrement@1` of a sensor mounted at `T_base_sensor` stands for: its
/// logarithm by the interval, (v, ω) of the sensor, and by the adjoint that of the base. Throws DataError if the
/// payload is another one, or no motion.
Twist twist_of(const Measurement& measurement, const Pose& T_base_sensor, const IncrementNoise& noise);

/// What a vehicle can do, at most.
struct Limits {
  double speed;                 ///< [m/s]
  double rate;                  ///< [rad/s]
  double acceleration;          ///< [m/s²]
  double angular_acceleration;  ///< [rad/s²]

  bool allow(const Twist& twist) const;
  /// Whether a vehicle that had the twist `before` can have this one `elapsed` later, up to 3σ of both.
  bool allow_change(const Twist& before, const Twist& twist, double elapsed) const;
  /// `before`, as well as it is known `elapsed` later.
  Twist extrapolate(const Twist& before, double elapsed) const;
};

}  // namespace waymark::relative
