// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <tuple>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/measurement.hpp"

/// The payloads exchanged between sources, sensors and maps. SI units. NaN only where a field has it for "not known".
/// `fields` defines every field's meaning; docs/payloads.md is generated from it.
namespace waymark {

/// Speeds of the left and right wheel of a differential drive.
struct WheelSpeeds : PayloadOf<WheelSpeeds> {
  static constexpr std::string_view kType = "waymark/WheelSpeeds@1";
  double left_mps = 0.0;
  double right_mps = 0.0;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&WheelSpeeds::left_mps, {.names = {"left_mps"}, .unit = "m/s", .meaning = "speed of the left wheel"});
    field(&WheelSpeeds::right_mps, {.names = {"right_mps"}, .unit = "m/s", .meaning = "speed of the right wheel"});
  }
};

/// Speed of one wheel and steering angle of a car-like vehicle.
struct WheelSteering : PayloadOf<WheelSteering> {
  static constexpr std::string_view kType = "waymark/WheelSteering@1";
  double speed_mps = 0.0;
  double steering_rad = 0.0;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&WheelSteering::speed_mps,
          {.names = {"speed_mps"}, .unit = "m/s", .meaning = "speed of the wheel that carries the encoder"});
    field(&WheelSteering::steering_rad,
          {.names = {"steering_rad"},
           .unit = "rad",
           .meaning = "steering angle of the equivalent bicycle's front wheel, left positive"});
  }
};

/// A twist in the base frame as odometry reports it.
struct BodyTwist : PayloadOf<BodyTwist> {
  static constexpr std::string_view kType = "waymark/BodyTwist@1";
  double v_x_mps = 0.0;
  double v_y_mps = 0.0;
  double w_z_radps = 0.0;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&BodyTwist::v_x_mps, {.names = {"v_x_mps"}, .unit = "m/s", .meaning = "forward velocity"});
    field(&BodyTwist::v_y_mps,
          {.names = {"v_y_mps"}, .unit = "m/s", .meaning = "velocity to the left", .required = false});
    field(&BodyTwist::w_z_radps, {.names = {"w_z_radps"}, .unit = "rad/s", .meaning = "yaw rate, left positive"});
  }
};

/// Motion of the base over an interval that begins at the stamp: odometry given as poses. It arrives at the end of the
/// interval.
struct PoseIncrement : PayloadOf<PoseIncrement> {
  static constexpr std::string_view kType = "waymark/PoseIncrement@1";
  double interval_s = 0.0;
  double x_m = 0.0;
  double y_m = 0.0;
  double yaw_rad = 0.0;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&PoseIncrement::interval_s,
          {.names = {"interval_s"}, .unit = "s", .meaning = "length of the interval, more than 0"});
    field(&PoseIncrement::x_m,
          {.names = {"x_m"},
           .unit = "m",
           .meaning = "position at the end of the interval, forward in the base's frame at the stamp"});
    field(&PoseIncrement::y_m, {.names = {"y_m"}, .unit = "m", .meaning = "the same, to the left"});
    field(
        &PoseIncrement::yaw_rad,
        {.names = {"yaw_rad"}, .unit = "rad", .meaning = "rotation over the interval, left positive, within (-π, π)"});
  }
  WAYMARK_API std::string_view contradiction() const;
};

/// One GNSS fix: local metres or geodetic, whichever the receiver or the log delivers.
struct GnssFix : PayloadOf<GnssFix> {
  static constexpr std::string_view kType = "waymark/GnssFix@1";
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  enum class Type { none, single, differential, rtk_float, rtk_fixed, unknown };
  static constexpr std::string_view kTypeWords[] = {"none",      "single",    "differential",
                                                    "rtk_float", "rtk_fixed", "unknown"};

  Eigen::Vector3d p_map_antenna{kUnknown, kUnknown, kUnknown};
  double latitude_deg = kUnknown;
  double longitude_deg = kUnknown;
  double height_m = kUnknown;
  double sigma_horizontal_m = kUnknown;
  double sigma_vertical_m = kUnknown;
  double hdop = kUnknown;
  int satellites = -1;
  Type type = Type::unknown;
  double speed_mps = kUnknown;
  double course_rad = kUnknown;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&GnssFix::p_map_antenna, {.names = {"east_m", "north_m", "up_m"},
                                    .unit = "m",
                                    .meaning = "position of the antenna in the map; or see latitude and longitude",
                                    .required = false,
                                    .unknown = "NaN",
                                    .separable = true});
    field(&GnssFix::latitude_deg, {.names = {"latitude_deg"},
                                   .unit = "deg",
                                   .meaning = "latitude, WGS-84",
                                   .required = false,
                                   .unknown = "NaN",
                                   .limit = 90.0});
    optional_number(field, &GnssFix::longitude_deg, "longitude_deg", "deg", "longitude, WGS-84");
    optional_number(field, &GnssFix::height_m, "height_m", "m", "height above the ellipsoid");
    optional_number(field, &GnssFix::sigma_horizontal_m, "sigma_horizontal_m", "m",
                    "σ per horizontal axis, as the receiver reports it");
    optional_number(field, &GnssFix::sigma_vertical_m, "sigma_vertical_m", "m",
                    "vertical σ, as the receiver reports it");
    optional_number(field, &GnssFix::hdop, "hdop", "", "horizontal dilution of precision");
    field(&GnssFix::satellites,
          {.names = {"satellites"}, .meaning = "satellites used", .required = false, .unknown = "-1"});
    field(&GnssFix::type,
          {.names = {"type"}, .meaning = "kind of the solution", .required = false, .words = kTypeWords});
    optional_number(field, &GnssFix::speed_mps, "speed_mps", "m/s",
                    "speed of the antenna over ground, as the receiver measures it by Doppler");
    optional_number(field, &GnssFix::course_rad, "course_rad", "rad",
                    "direction of that velocity, clockwise from true north; without meaning at standstill");
  }
  WAYMARK_API std::string_view contradiction() const;

 private:
  template <class Visitor>
  static void optional_number(Visitor&& field, double GnssFix::*member, std::string_view name, std::string_view unit,
                              std::string_view meaning) {
    field(member, {.names = {name}, .unit = unit, .meaning = meaning, .required = false, .unknown = "NaN"});
  }
};
constexpr GnssFix::Type last_of(GnssFix::Type /*type*/) { return GnssFix::Type::unknown; }

/// One sweep of a planar laser scanner. Beam k points at start_rad + k · step_rad, counter-clockwise from the sensor's
/// x axis.
struct LaserScan : PayloadOf<LaserScan> {
  static constexpr std::string_view kType = "waymark/LaserScan@1";
  double start_rad = 0.0;
  double step_rad = 0.0;
  double beam_interval_s = 0.0;
  std::vector<float> ranges_m;
  std::vector<float> intensities;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&LaserScan::start_rad, {.names = {"start_rad"}, .unit = "rad", .meaning = "direction of beam 0"});
    field(&LaserScan::step_rad,
          {.names = {"step_rad"}, .unit = "rad", .meaning = "angle from one beam to the next, not 0"});
    field(&LaserScan::beam_interval_s,
          {.names = {"beam_interval_s"},
           .unit = "s",
           .meaning = "time from one beam to the next; beam 0 is at the stamp. 0: all beams are",
           .required = false});
    field(&LaserScan::ranges_m, {.names = {"ranges_m"},
                                 .unit = "m",
                                 .meaning = "one per beam, as the scanner delivers them; the YAML of the map module "
                                            "defines which are without return",
                                 .unknown = "∞"});
    field(&LaserScan::intensities, {.names = {"intensities"},
                                    .meaning = "none, or one per beam, in the scanner's unit",
                                    .required = false,
                                    .unknown = "NaN"});
  }
  /// Where beam `k` ends in the sensor's frame [m].
  WAYMARK_API Eigen::Vector3d p_sensor_end(std::ptrdiff_t k) const;
  WAYMARK_API std::string_view contradiction() const;
};

/// One sweep or burst of a three-dimensional scanner, radar or depth camera.
struct PointCloud : PayloadOf<PointCloud> {
  static constexpr std::string_view kType = "waymark/PointCloud@1";
  std::vector<Eigen::Vector3f> points_m;
  std::vector<float> offsets_s;
  std::vector<float> intensities;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&PointCloud::points_m, {.names = {"points_m"},
                                  .unit = "m",
                                  .meaning = "end points in the sensor's frame; beams without return are left out"});
    field(&PointCloud::offsets_s, {.names = {"offsets_s"},
                                   .unit = "s",
                                   .meaning = "none, or the time of each point after the stamp",
                                   .required = false});
    field(&PointCloud::intensities, {.names = {"intensities"},
                                     .meaning = "none, or one per point, in the scanner's unit",
                                     .required = false,
                                     .unknown = "NaN"});
  }
  WAYMARK_API std::string_view contradiction() const;
};

/// One image of a camera, as pixels or as the compressed file that the device or the log delivers.
struct Image : PayloadOf<Image> {
  static constexpr std::string_view kType = "waymark/Image@1";
  enum class Encoding { bgr8, mono8, compressed };  ///< compressed: JPEG or PNG, width and height are inside
  static constexpr std::string_view kEncodingWords[] = {"bgr8", "mono8", "compressed"};

  Encoding encoding = Encoding::bgr8;
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> data;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Image::encoding, {.names = {"encoding"},
                             .meaning = "form of the data; compressed: JPEG or PNG, width and height are inside",
                             .words = kEncodingWords});
    field(&Image::width,
          {.names = {"width"}, .unit = "px", .meaning = "width; not of a compressed image", .required = false});
    field(&Image::height,
          {.names = {"height"}, .unit = "px", .meaning = "height; not of a compressed image", .required = false});
    field(&Image::data, {.names = {"data"}, .meaning = "rows from the top, without padding; or the file"});
  }
};

/// One sample of an inertial measurement unit, in the sensor's frame.
struct ImuSample : PayloadOf<ImuSample> {
  static constexpr std::string_view kType = "waymark/ImuSample@1";
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  Eigen::Vector3d w_sensor{kUnknown, kUnknown, kUnknown};
  Eigen::Vector3d f_sensor{kUnknown, kUnknown, kUnknown};
  Eigen::Vector3d m_sensor{kUnknown, kUnknown, kUnknown};
  Eigen::Quaterniond q_enu_sensor{kUnknown, kUnknown, kUnknown, kUnknown};

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&ImuSample::w_sensor, {.names = {"w_x_radps", "w_y_radps", "w_z_radps"},
                                 .unit = "rad/s",
                                 .meaning = "angular rate",
                                 .unknown = "NaN"});
    field(&ImuSample::f_sensor, {.names = {"f_x_mps2", "f_y_mps2", "f_z_mps2"},
                                 .unit = "m/s²",
                                 .meaning = "specific force: +9.81 upwards at rest",
                                 .required = false,
                                 .unknown = "NaN"});
    field(&ImuSample::m_sensor, {.names = {"m_x_t", "m_y_t", "m_z_t"},
                                 .unit = "T",
                                 .meaning = "magnetic field",
                                 .required = false,
                                 .unknown = "NaN"});
    field(&ImuSample::q_enu_sensor,
          {.names = {"q_w", "q_x", "q_y", "q_z"},
           .meaning = "orientation estimated by the device: rotates vectors of the sensor to east, north, up (of "
                      "magnetic north, if the YAML declares it)",
           .required = false,
           .unknown = "NaN"});
  }
  WAYMARK_API std::string_view contradiction() const;
};

/// The magnetic field alone, in the sensor's frame: of a compass that delivers a vector.
struct MagneticField : PayloadOf<MagneticField> {
  static constexpr std::string_view kType = "waymark/MagneticField@1";
  Eigen::Vector3d m_sensor = Eigen::Vector3d::Zero();

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&MagneticField::m_sensor, {.names = {"m_x_t", "m_y_t", "m_z_t"}, .unit = "T", .meaning = "magnetic field"});
  }
};

/// Heading of a compass: direction of the sensor's x axis, clockwise from north.
struct CompassHeading : PayloadOf<CompassHeading> {
  static constexpr std::string_view kType = "waymark/CompassHeading@1";
  double heading_rad = 0.0;
  double sigma_rad = std::numeric_limits<double>::quiet_NaN();
  bool from_true_north = false;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&CompassHeading::heading_rad,
          {.names = {"heading_rad"}, .unit = "rad", .meaning = "heading, clockwise from north"});
    field(&CompassHeading::sigma_rad, {.names = {"sigma_rad"},
                                       .unit = "rad",
                                       .meaning = "its σ, as the device reports it",
                                       .required = false,
                                       .unknown = "NaN"});
    field(&CompassHeading::from_true_north,
          {.names = {"from_true_north"},
           .meaning = "true: of a gyrocompass or GNSS compass; false: from magnetic north",
           .required = false});
  }
};

/// Height of the sensor above the ground or above a fixed level: ultrasound, barometer.
struct Height : PayloadOf<Height> {
  static constexpr std::string_view kType = "waymark/Height@1";
  double height_m = 0.0;
  double sigma_m = std::numeric_limits<double>::quiet_NaN();

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Height::height_m, {.names = {"height_m"}, .unit = "m", .meaning = "height"});
    field(&Height::sigma_m, {.names = {"sigma_m"},
                             .unit = "m",
                             .meaning = "its σ, as the device reports it",
                             .required = false,
                             .unknown = "NaN"});
  }
};

/// Landmarks detected by a device or a source: all of one image or sweep are one observation set.
struct LandmarkObservations : PayloadOf<LandmarkObservations> {
  static constexpr std::string_view kType = "waymark/LandmarkObservations@1";
  /// One landmark.
  struct One {
    double range_m = 0.0;
    double bearing_rad = 0.0;
    double radius_m = std::numeric_limits<double>::quiet_NaN();
    int identity = -1;

    template <class Visitor>
    static void fields(Visitor&& field) {
      field(&One::range_m,
            {.names = {"range_m"}, .unit = "m", .meaning = "distance from the sensor to the landmark's centre"});
      field(&One::bearing_rad, {.names = {"bearing_rad"},
                                .unit = "rad",
                                .meaning = "its direction, counter-clockwise from the sensor's x axis"});
      field(&One::radius_m,
            {.names = {"radius_m"}, .unit = "m", .meaning = "its radius", .required = false, .unknown = "NaN"});
      field(&One::identity, {.names = {"identity"},
                             .meaning = "the number that was read (a barcode, a tag); -1: nothing was read",
                             .required = false});
    }
  };
  std::vector<One> landmarks;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&LandmarkObservations::landmarks,
          {.names = {"landmarks"}, .meaning = "may be empty: no detection is an observation, too"});
  }
  WAYMARK_API std::string_view contradiction() const;
};

/// Ranges that one receiver measured to radio beacons, by time of flight or, as differences, by time of arrival: all of
/// one burst are one observation set.
struct Ranges : PayloadOf<Ranges> {
  static constexpr std::string_view kType = "waymark/Ranges@1";
  /// One range, or a difference of two.
  struct One {
    int beacon = -1;
    double range_m = 0.0;
    int reference = -1;
    double sigma_m = std::numeric_limits<double>::quiet_NaN();

    template <class Visitor>
    static void fields(Visitor&& field) {
      field(&One::beacon, {.names = {"beacon"}, .meaning = "number of the beacon, 0 or more"});
      field(&One::range_m, {.names = {"range_m"},
                            .unit = "m",
                            .meaning = "distance from the receiver to the beacon; with a reference, that distance "
                                       "less the one to the reference"});
      field(&One::reference,
            {.names = {"reference"},
             .meaning = "of a difference of ranges: number of the beacon whose range is subtracted; -1: of none",
             .required = false});
      field(&One::sigma_m, {.names = {"sigma_m"},
                            .unit = "m",
                            .meaning = "its σ, as the device reports it",
                            .required = false,
                            .unknown = "NaN"});
    }
  };
  std::vector<One> ranges;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Ranges::ranges, {.names = {"ranges"}, .meaning = "may be empty"});
  }
  WAYMARK_API std::string_view contradiction() const;
};

/// Targets of one scan of a radar that measures radial velocities (Doppler).
struct RadarTargets : PayloadOf<RadarTargets> {
  static constexpr std::string_view kType = "waymark/RadarTargets@1";
  /// One target, in the radar's frame.
  struct One {
    double range_m = 0.0;
    double azimuth_rad = 0.0;
    double elevation_rad = 0.0;
    double radial_mps = 0.0;
    double rcs_dbsm = std::numeric_limits<double>::quiet_NaN();

    template <class Visitor>
    static void fields(Visitor&& field) {
      field(&One::range_m, {.names = {"range_m"}, .unit = "m", .meaning = "distance from the radar"});
      field(&One::azimuth_rad, {.names = {"azimuth_rad"},
                                .unit = "rad",
                                .meaning = "direction in the radar's x-y plane, counter-clockwise from its x axis"});
      field(&One::elevation_rad, {.names = {"elevation_rad"},
                                  .unit = "rad",
                                  .meaning = "angle above that plane; 0 of a planar radar",
                                  .required = false});
      field(&One::radial_mps, {.names = {"radial_mps"},
                               .unit = "m/s",
                               .meaning = "radial velocity relative to the radar, positive of a target that recedes"});
      field(&One::rcs_dbsm, {.names = {"rcs_dbsm"},
                             .unit = "dBsm",
                             .meaning = "radar cross-section",
                             .required = false,
                             .unknown = "NaN"});
    }
  };
  std::vector<One> targets;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&RadarTargets::targets, {.names = {"targets"}, .meaning = "may be empty"});
  }
  WAYMARK_API std::string_view contradiction() const;
};

/// All payloads of core, in the order of reference pages.
using CorePayloads =
    std::tuple<WheelSpeeds, WheelSteering, BodyTwist, PoseIncrement, GnssFix, LaserScan, PointCloud, Image, ImuSample,
               CompassHeading, MagneticField, Height, LandmarkObservations, Ranges, RadarTargets>;

/// A payload with its defaults by its versioned name, of core or registered by a plugin (payload_registry.hpp); null if
/// there is none of that name.
WAYMARK_API std::shared_ptr<Payload> make_payload(std::string_view type);

}  // namespace waymark
