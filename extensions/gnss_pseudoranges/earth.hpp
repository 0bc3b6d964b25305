// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "waymark/interface/sensor.hpp"

/// WGS-84, and the axes east, north, up at a datum.
namespace waymark::gnss {

inline constexpr double kEarthRadius = 6378137.0;                  // [m]
inline constexpr double kEccentricitySquared = 6.69437999014e-3;   // [-]
inline constexpr double kRadPerDegree = std::numbers::pi / 180.0;  // [rad/°]
inline constexpr double kRotation = 7.2921151467e-5;               // of the Earth [rad/s]
inline constexpr double kLight = 299792458.0;                      // [m/s]

inline Eigen::Vector3d to_ecef(const Datum& datum) {
  const double latitude = datum.latitude_deg * kRadPerDegree;
  const double longitude = datum.longitude_deg * kRadPerDegree;
  const double sine = std::sin(latitude);
  const double normal = kEarthRadius / std::sqrt(1.0 - kEccentricitySquared * sine * sine);
  const double out = (normal + datum.height_m) * std::cos(latitude);
  return {out * std::cos(longitude), out * std::sin(longitude),
          (normal * (1.0 - kEccentricitySquared) + datum.height_m) * sine};
}

inline Datum to_datum(const Eigen::Vector3d& p_ecef) {
  const double out = p_ecef.head<2>().norm();
  double latitude = std::atan2(p_ecef.z(), out * (1.0 - kEccentricitySquared));
  double height = 0.0;
  for (int i = 0; i < 6; ++i) {
    const double sine = std::sin(latitude);
    const double normal = kEarthRadius / std::sqrt(1.0 - kEccentricitySquared * sine * sine);
    height = out / std::cos(latitude) - normal;
    latitude = std::atan2(p_ecef.z(), out * (1.0 - kEccentricitySquared * normal / (normal + height)));
  }
  return {latitude / kRadPerDegree, std::atan2(p_ecef.y(), p_ecef.x()) / kRadPerDegree, height};
}

/// The map's axes at its datum.
class LocalAxes {
 public:
  explicit LocalAxes(const Datum& datum)
      : R_enu_ecef_(axes(datum.latitude_deg * kRadPerDegree, datum.longitude_deg * kRadPerDegree)),
        p_ecef_(to_ecef(datum)) {}

  Eigen::Vector3d to_enu(const Eigen::Vector3d& p_ecef) const { return R_enu_ecef_ * (p_ecef - p_ecef_); }
  /// A satellite in the axes of the time of reception: the Earth turns while the signal travels (G. Sagnac, 1913).
  Eigen::Vector3d satellite(const Eigen::Vector3d& p_ecef) const {
    const double turned = kRotation / kLight * (p_ecef - p_ecef_).norm();
    return to_enu(Eigen::AngleAxisd(-turned, Eigen::Vector3d::UnitZ()) * p_ecef);
  }

 private:
  static Eigen::Matrix3d axes(double latitude, double longitude) {
    const Eigen::Vector3d east(-std::sin(longitude), std::cos(longitude), 0.0);
    const Eigen::Vector3d up(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                             std::sin(latitude));
    Eigen::Matrix3d R;
    R << east.transpose(), up.cross(east).transpose(), up.transpose();
    return R;
  }

  Eigen::Matrix3d R_enu_ecef_;
  Eigen::Vector3d p_ecef_;
};

}  // namespace waymark::gnss
