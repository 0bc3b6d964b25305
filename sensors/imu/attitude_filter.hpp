// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "attitude_settings.hpp"
#include "low_pass.hpp"
#include "magnetic_field.hpp"
#include "rest_detector.hpp"
#include "saturation.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::imu {

/// Attitude and gyro bias of one inertial measurement unit from its own nine axes: an error-state Kalman filter with
/// six errors, the attitude's (left perturbation in the map frame [rad]: R_true = Exp(δ) R) and the gyro bias' (sensor
/// frame [rad/s]). The map frame is east-north-up; without a magnetometer its heading is that of the start, without an
/// accelerometer the whole attitude is relative to the start.
///
/// - The gyro predicts, once per sample.
/// - The specific force is low-passed in the map frame, where it is nearly constant, as in VQF (D. Laidig, T. Seel,
///   Information Fusion 91, 2023). The filter takes its direction as a measurement of roll and pitch, with the lag of
///   the low-pass in the Jacobian (so the bias is observed in motion too) and noise that grows with the motion.
/// - The magnetometer corrects the heading and the bias, never roll and pitch; a field of wrong strength or dip is
///   refused.
/// - At rest the low-passed rate is the bias.
/// - A gyro at the end of its range makes the attitude uncertain; specific force and field then find it again.
///
/// No heap allocation per sample. The same samples give the same bytes.
class AttitudeFilter {
 public:
  using Covariance = Eigen::Matrix<double, 6, 6>;

  /// What became of the samples.
  struct Counts {
    std::uint64_t used = 0;
    std::uint64_t without_rate = 0;   ///< ignored: the angular rate is not finite
    std::uint64_t out_of_order = 0;   ///< ignored: not after the one before
    std::uint64_t without_force = 0;  ///< used, but no finite specific force in it
    std::uint64_t without_field = 0;  ///< used, but no finite magnetic field in it
    std::uint64_t disturbed = 0;      ///< used, but the field was refused
    std::uint64_t saturated = 0;      ///< used, but the rate is at the end of the gyro's range
    std::uint64_t gaps = 0;           ///< longer than `max_gap_s`

    template <class Archive>
    void serialize(Archive& archive) {
      archive(used, without_rate, out_of_order, without_force, without_field, disturbed, saturated, gaps);
    }
  };

  explicit AttitudeFilter(const AttitudeSettings& settings = {});

  /// Takes one sample; false if it was ignored.
  bool process(Time stamp, const ImuSample& sample);

  /// Start-up levelling is over. Before that `q_map_sensor` is what is known so far.
  bool levelled() const { return levelled_; }
  bool knows_tilt() const { return knows_tilt_; }        ///< roll and pitch are absolute: there is an accelerometer
  bool knows_heading() const { return knows_heading_; }  ///< so is the heading: there is a magnetometer
  bool resting() const { return rest_.resting(settings_); }
  /// The magnetic field is refused at present.
  bool disturbed() const { return knows_heading_ && !field_.usable(settings_); }

  const Eigen::Quaterniond& q_map_sensor() const { return q_; }
  const Eigen::Vector3d& gyro_bias() const { return bias_; }  ///< sensor frame [rad/s]
  const Eigen::Vector3d& angular_rate() const {
    return w_;
  }                                                    ///< of the last sample, free of bias, sensor frame [rad/s]
  const Covariance& covariance() const { return P_; }  ///< attitude (map frame) first, then bias
  /// Mean specific force of the last levelling, in the sensor frame at its end [m/s²]; zero without an accelerometer.
  const Eigen::Vector3d& levelling_force() const { return levelling_force_; }
  const MagneticField& field() const { return field_; }
  const Counts& counts() const { return counts_; }
  const AttitudeSettings& settings() const { return settings_; }

  /// The settings are not part of it: load into a filter with the same ones.
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("attitude_filter", 1);
    archive(q_, bias_, w_, last_rate_, P_, last_stamp_, levelled_, knows_tilt_, knows_heading_, q_map_level_,
            q_level_sensor_, force_sum_, field_sum_);
    for (std::int64_t* count : {&force_count_, &field_count_}) archive.within(*count, 0, std::int64_t{1} << 62);
    archive(levelling_s_, levelling_force_, force_, attitude_, motion_, since_restart_s_, since_force_s_,
            since_field_s_, field_, rest_, surprise_s_, saturation_, counts_);
  }

 private:
  void begin_levelling();
  void level(const ImuSample& sample, double dt);
  void finish_levelling(const Eigen::Vector3d& f_level, const Eigen::Vector3d& m_level);
  void predict(const Eigen::Vector3d& w_sensor, double dt);
  void lose_what_saturates(const Eigen::Vector3d& saturated_s);
  void correct_by_rest(double dt);
  void correct_by_force(const Eigen::Vector3d& f_sensor);
  void correct_by_field(const Eigen::Vector3d& m_sensor, double turn_rate);
  void restart_low_pass(const Eigen::Vector3d& f_map);
  double tilt_variance() const { return std::max(P_(0, 0), P_(1, 1)); }
  template <int Rows>
  void correct(const Eigen::Matrix<double, Rows, 6>& H, const Eigen::Matrix<double, Rows, 1>& residual,
               const Eigen::Matrix<double, Rows, Rows>& R, bool hold_tilt);

  AttitudeSettings settings_;
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_rate_ = Eigen::Vector3d::Zero();  // as measured
  Covariance P_ = Covariance::Zero();
  std::optional<Time> last_stamp_;

  bool levelled_ = false;
  bool knows_tilt_ = false;
  bool knows_heading_ = false;
  // Levelling: sums in the frame that the sensor had at its beginning.
  Eigen::Quaterniond q_map_level_ = Eigen::Quaterniond::Identity();
  Eigen::Quaterniond q_level_sensor_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d field_sum_ = Eigen::Vector3d::Zero();
  std::int64_t force_count_ = 0;
  std::int64_t field_count_ = 0;
  double levelling_s_ = 0.0;
  Eigen::Vector3d levelling_force_ = Eigen::Vector3d::Zero();

  ButterworthLowPass<Eigen::Vector3d> force_;              // specific force in the map frame
  ButterworthLowPass<Eigen::Matrix3d> attitude_;           // the attitude's matrix: how the bias comes through
  FirstOrderLowPass<Eigen::Matrix<double, 1, 1>> motion_;  // squared deviation from force_ [m²/s⁴]
  double since_restart_s_ = 0.0;                           // of the low-pass
  double since_force_s_ = 0.0;
  double since_field_s_ = 0.0;
  MagneticField field_;
  RestDetector rest_;
  double surprise_s_ = 0.0;  // for how long a rest has contradicted the bias
  SaturationDetector saturation_;
  Counts counts_;
};

/// What is wrong with the mounting if the sensor, held by `q_base_sensor`, feels `f_sensor` [m/s²] while the base is
/// level: "gravity points along +y of the sensor: check the mounting"; nothing if up is within `limit` [rad] of the
/// base's z axis.
std::optional<std::string> mounting_fault(const Eigen::Vector3d& f_sensor, const Eigen::Quaterniond& q_base_sensor,
                                          double limit = 45.0 * AttitudeSettings::kDegree);

}  // namespace waymark::imu
