// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "waymark/interface/measurement.hpp"

/// The payloads that cross between sources, sensors and maps. SI units; NaN only where a field says so.
namespace waymark {

/// Speeds of the left and right wheel of a differential drive.
struct WheelSpeeds : PayloadOf<WheelSpeeds> {
  static constexpr std::string_view kType = "waymark/WheelSpeeds@1";
  double left_mps = 0.0;
  double right_mps = 0.0;
};

/// Speed of one wheel and steering angle of a car-like vehicle.
struct WheelSteering : PayloadOf<WheelSteering> {
  static constexpr std::string_view kType = "waymark/WheelSteering@1";
  double speed_mps = 0.0;     ///< of the wheel that carries the encoder
  double steering_rad = 0.0;  ///< of the equivalent bicycle's front wheel, left positive
};

/// A twist in the base frame as odometry reports it.
struct BodyTwist : PayloadOf<BodyTwist> {
  static constexpr std::string_view kType = "waymark/BodyTwist@1";
  double v_x_mps = 0.0;
  double v_y_mps = 0.0;
  double w_z_radps = 0.0;
};

/// How far the base moved in the time from the stamp on: odometry that is given as poses. It becomes known at the end
/// of that time.
struct PoseIncrement : PayloadOf<PoseIncrement> {
  static constexpr std::string_view kType = "waymark/PoseIncrement@1";
  double interval_s = 0.0;  ///< > 0
  double x_m = 0.0;         ///< the end in the base's frame at the stamp
  double y_m = 0.0;
  double yaw_rad = 0.0;  ///< in (-pi, pi)
};

/// One GNSS fix: local metres or geodetic, whichever the receiver or the log delivers.
struct GnssFix : PayloadOf<GnssFix> {
  static constexpr std::string_view kType = "waymark/GnssFix@1";
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  enum class Type { none, single, differential, rtk_float, rtk_fixed, unknown };

  Eigen::Vector3d p_map_antenna{kUnknown, kUnknown,
                                kUnknown};  ///< east, north, up [m]; NaN: see the geodetic fields; up may be NaN
  double latitude_deg = kUnknown;           ///< WGS-84
  double longitude_deg = kUnknown;          ///< WGS-84
  double height_m = kUnknown;               ///< above the ellipsoid
  double sigma_horizontal_m = kUnknown;     ///< per axis, as the receiver reports it
  double sigma_vertical_m = kUnknown;
  double hdop = kUnknown;
  int satellites = -1;  ///< -1: unknown
  Type type = Type::unknown;
  double speed_mps = kUnknown;   ///< of the antenna over ground, as the receiver measures it by Doppler
  double course_rad = kUnknown;  ///< of that velocity, clockwise from true north; without meaning at standstill
};

/// One sweep of a planar laser scanner. Beam k points at start_rad + k · step_rad, counter-clockwise from the sensor's
/// x axis.
struct LaserScan : PayloadOf<LaserScan> {
  static constexpr std::string_view kType = "waymark/LaserScan@1";
  double start_rad = 0.0;
  double step_rad = 0.0;
  double beam_interval_s = 0.0;    ///< time from one beam to the next; beam 0 is at the stamp. 0: all are
  std::vector<float> ranges_m;     ///< as the scanner gives them; what is no return, the YAML of the map module says
  std::vector<float> intensities;  ///< empty, or one per beam; unit of the scanner
};

/// One sweep or burst of a three-dimensional scanner, radar or depth camera.
struct PointCloud : PayloadOf<PointCloud> {
  static constexpr std::string_view kType = "waymark/PointCloud@1";
  std::vector<Eigen::Vector3f> points_m;  ///< end points in the sensor's frame; only of what came back
  std::vector<float> offsets_s;           ///< empty, or when each point was measured, after the stamp
  std::vector<float> intensities;         ///< empty, or one per point; unit of the scanner
};

/// One image of a camera, as pixels or as the compressed file that the device or the log delivers.
struct Image : PayloadOf<Image> {
  static constexpr std::string_view kType = "waymark/Image@1";
  enum class Encoding { bgr8, mono8, compressed };  ///< compressed: JPEG or PNG, width and height are inside

  Encoding encoding = Encoding::bgr8;
  int width = 0;                   ///< [px]; not of a compressed image
  int height = 0;                  ///< [px]
  std::vector<std::uint8_t> data;  ///< rows from the top, without padding; or the file
};

/// One sample of an inertial measurement unit, in the sensor's frame.
struct ImuSample : PayloadOf<ImuSample> {
  static constexpr std::string_view kType = "waymark/ImuSample@1";
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  Eigen::Vector3d w_sensor{kUnknown, kUnknown, kUnknown};  ///< angular rate [rad/s]
  Eigen::Vector3d f_sensor{kUnknown, kUnknown, kUnknown};  ///< specific force [m/s²]: +9.81 upwards at rest; NaN: none
  Eigen::Vector3d m_sensor{kUnknown, kUnknown, kUnknown};  ///< magnetic field [T]; NaN: none
  /// What the device made of its axes by itself: vectors of the sensor turned to east, north, up (of magnetic north, if
  /// it says so in the YAML); NaN: none.
  Eigen::Quaterniond q_enu_sensor{kUnknown, kUnknown, kUnknown, kUnknown};
};

/// The magnetic field alone, in the sensor's frame: of a compass that delivers a vector.
struct MagneticField : PayloadOf<MagneticField> {
  static constexpr std::string_view kType = "waymark/MagneticField@1";
  Eigen::Vector3d m_sensor = Eigen::Vector3d::Zero();  ///< [T]
};

/// What a compass shows: where the sensor's x axis points, clockwise as on a compass rose.
struct CompassHeading : PayloadOf<CompassHeading> {
  static constexpr std::string_view kType = "waymark/CompassHeading@1";
  double heading_rad = 0.0;
  double sigma_rad = std::numeric_limits<double>::quiet_NaN();  ///< as the device reports it; NaN: unknown
  bool from_true_north = false;  ///< true: a gyrocompass or GNSS compass; false: from magnetic north
};

/// How high the sensor is above the ground or above a fixed level: ultrasound, barometer.
struct Height : PayloadOf<Height> {
  static constexpr std::string_view kType = "waymark/Height@1";
  double height_m = 0.0;
  double sigma_m = std::numeric_limits<double>::quiet_NaN();  ///< as the device reports it; NaN: unknown
};

/// Landmarks that a device or a source detected by itself: all of one image or sweep are one observation set.
struct LandmarkObservations : PayloadOf<LandmarkObservations> {
  static constexpr std::string_view kType = "waymark/LandmarkObservations@1";
  struct One {
    double range_m = 0.0;                                        ///< from the sensor to the landmark's centre
    double bearing_rad = 0.0;                                    ///< counter-clockwise from the sensor's x axis
    double radius_m = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not measured
    int identity = -1;                                           ///< what was read (a barcode, a tag); -1: nothing
  };
  std::vector<One> landmarks;  ///< may be empty: seen nothing is an observation too
};

}  // namespace waymark
