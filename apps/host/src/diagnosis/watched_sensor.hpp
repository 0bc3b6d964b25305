// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "scan_registration.hpp"
#include "track.hpp"
#include "waymark/interface/observed_motion.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::host::diagnosis {

/// Values of a long log, thinned out evenly to a bounded number.
class Thinned {
 public:
  static constexpr std::size_t kMost = 1024;
  Thinned() { values_.reserve(kMost); }
  void add(double value);
  /// Value below which a share of all lies; 0 if there are none.
  double quantile(double share) const;
  std::size_t size() const { return values_.size(); }

 private:
  std::vector<double> values_;
  long every_ = 1;
  long seen_ = 0;
};

inline constexpr double kGravity = 9.81;  // [m/s²]
inline constexpr int kManyDecimals = 9;

/// A fix and its time in the window [s].
struct Fix {
  double t;
  Eigen::Vector2d p;
};

/// The motion of a scanner between two scans, its plane turned as it is mounted, without its lever arm.
struct ScanStep {
  double from;
  double to;
  Eigen::Vector2d shift;  ///< in the axes of the base at `from`
  bool is_shift_known;
  double yaw;
};

/// What a sensor is for the comparisons: by what it measures, not by its plugin.
enum class Role { wheels, gyro, heading, scanner, fix, other };

/// Over kVectorSpan: how a vector that stays in the world (gravity, the Earth's field) changes in the axes of the base.
struct TurnedVector {
  Eigen::Vector3d change;
  Eigen::Matrix3d products;  ///< ∫ ω vᵀ dt, by the gyro's ω
  Eigen::Vector3d sum;       ///< ∫ v dt
  Eigen::Vector3d turn;      ///< ∫ ω dt

  /// What it changes by as the robot turns, −∫ ω × v dt.
  Eigen::Vector3d by_turn() const;
};
inline constexpr double kVectorSpan = 1.0;  ///< [s]; in a longer one the robot's own accelerations change more

/// What is kept of one sensor's measurements.
struct WatchedSensor {
  std::string name;
  std::string plugin;
  std::string payload;  ///< type of its last measurement
  bool is_watched = false;
  Pose T_base_sensor;
  Duration delay{};  ///< of its stamps, as the YAML gives it

  // Of the whole log.
  Thinned intervals;  ///< between two stamps [s]
  Thinned speeds;     ///< magnitudes
  Thinned rates;
  Thinned forces;
  Thinned fields;
  Thinned headings;  ///< magnitude of what a compass delivers
  Thinned ranges;
  Thinned sweeps;  ///< time that the beams of one scan take [s]
  Thinned courses;
  Thinned steerings;
  std::optional<Time> first_stamp;
  std::optional<Time> last_stamp;
  int decimals = 0;  ///< of latitude and longitude, as many as a fix has at most; kManyDecimals: rounded by nothing
  Eigen::Vector3d force_sum = Eigen::Vector3d::Zero();
  long force_count = 0;
  double latitude_deg = ObservedMotion::kUnknown;  ///< of the first fix
  double longitude_deg = ObservedMotion::kUnknown;
  bool steps_backwards = false;  ///< beams of its scans go clockwise

  // Of the window.
  Track yaw;
  Track way;
  Track sideways;  ///< way to the left; from the first one on that is not 0
  Track course;    ///< direction of the motion over ground, where the speed is measured by itself
  Track ground_way;
  Track velocity_east;  ///< of a receiver, summed up [m]
  Track velocity_north;
  bool has_heading = false;  ///< `yaw` counts from east
  Track heading;             ///< the heading of a sensor whose `yaw` is that of its gyro
  VectorTrack force;         ///< specific force [m/s]
  VectorTrack turn;          ///< of a gyro [rad]
  VectorTrack field;         ///< magnetic field [T s]
  Track height;              ///< of the base in the map
  std::vector<Fix> fixes;
  std::vector<ScanStep> steps;
  ObservedMotion usual;  ///< its newest one, for the errors that are usual

  // Scans are compared in pairs.
  ThinScan scans[2];
  double largest_range = 0.0;
  double scan_t = -1.0;      ///< of the first scan of a pair; < 0: there is none
  int scans_to_second = 0;   ///< how many scans are left to the second one
  double next_scan_t = 0.0;  ///< the next pair begins then
  double pair_step = 0.3;    ///< [s] from one scan of a pair to the other; shorter after a failure

  Role role() const;
  /// True if it measures its height and nothing else.
  bool is_altimeter() const;
  void clear_window();
};

/// From time t on, with the vector averaged over so long before and after; nothing if it is not known throughout.
std::optional<TurnedVector> turned_vector(const VectorTrack& turn, const VectorTrack& vector, double t,
                                          double half_window);

/// A magnetic field and the direction in which gravity seems to lie, in the axes of the base.
struct TiltedField {
  Eigen::Vector2d lean;   ///< specific force in the plane, by gravity
  Eigen::Vector3d field;  ///< [T]
};

/// Averaged over so long before and after a time; nothing if it is not known.
std::optional<TiltedField> tilted_field(const WatchedSensor& magnetometer, const WatchedSensor& imu, double t,
                                        double half_window);

/// The axis of the sensor that lies closest to one of the base: 'x', 'y' or 'z'.
char axis_along(const WatchedSensor& sensor, const Eigen::Vector3d& base_axis);

}  // namespace waymark::host::diagnosis
