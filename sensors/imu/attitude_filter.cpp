// SPDX-License-Identifier: Apache-2.0
#include "attitude_filter.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "waymark/math/so3.hpp"

namespace waymark::imu {

namespace {

constexpr double kMinForce = 0.1;   // of gravity: less is not an accelerometer, or free fall
constexpr double kMinAngle = 0.05;  // [rad] between field and vertical: a steeper field gives no heading

double square(double x) { return x * x; }

/// Errors that stay for `time` [s] count as one measurement in twice that time (docs/math/imu.md). One measurement
/// alone has its whole variance: so it is taken while the state is much less certain than that.
double correlated(double variance, double time, double dt, double state_variance) {
  if (state_variance > 9.0 * variance) return variance;
  return variance * std::max(1.0, 2.0 * time / std::max(dt, 1e-6));
}

/// The rotation that turns `up` into the map's z axis without turning about it, as a rotation vector.
Eigen::Vector3d tilt_of(const Eigen::Vector3d& up) {
  const Eigen::Vector3d axis(up.y(), -up.x(), 0.0);
  const double sine = axis.norm();
  if (sine < 1e-12 * up.norm())
    return up.z() >= 0.0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(std::numbers::pi, 0, 0);
  return axis * (std::atan2(sine, up.z()) / sine);
}

}  // namespace

AttitudeFilter::AttitudeFilter(const AttitudeSettings& settings)
    : settings_(settings), force_(settings.accelerometer_time_s), attitude_(settings.accelerometer_time_s) {
  P_.diagonal().tail<3>().setConstant(square(settings_.bias_sigma));
  begin_levelling();
}

bool AttitudeFilter::process(Time stamp, const ImuSample& sample) {
  if (!sample.w_sensor.allFinite()) {
    ++counts_.without_rate;
    return false;
  }
  if (last_stamp_ && stamp <= *last_stamp_) {
    ++counts_.out_of_order;
    return false;
  }
  const double dt = last_stamp_ ? to_seconds(stamp - *last_stamp_) : 0.0;
  const bool has_force = sample.f_sensor.allFinite() && sample.f_sensor.squaredNorm() > 0.0;
  const bool has_field = sample.m_sensor.allFinite() && sample.m_sensor.squaredNorm() > 0.0;
  ++counts_.used;
  if (!has_force) ++counts_.without_force;
  if (!has_field) ++counts_.without_field;

  if (dt > settings_.max_gap_s) {
    ++counts_.gaps;
    // The rotation meanwhile is unknown; the heading is uniform.
    P_.topRows<3>().setZero();
    P_.leftCols<3>().setZero();
    P_.diagonal().head<3>().setConstant(square(std::numbers::pi) / 3.0);
    P_.diagonal().tail<3>().array() += square(settings_.bias_walk) * dt;
    rest_.reset();
    last_rate_ = sample.w_sensor;
    begin_levelling();
  } else if (levelled_ && ((has_force && !knows_tilt_) || (has_field && knows_tilt_ && !knows_heading_))) {
    begin_levelling();  // an axis that was silent until now
  }
  if (!last_stamp_) last_rate_ = sample.w_sensor;
  last_stamp_ = stamp;

  const double step = dt > settings_.max_gap_s ? 0.0 : dt;
  rest_.step(settings_, sample.w_sensor, sample.f_sensor, step);
  predict(sample.w_sensor, step);
  lose_what_saturates(saturation_.step(settings_, sample.w_sensor, step));
  if (!rest_.resting(settings_)) {
    surprise_s_ = 0.0;
  } else if (step > 0.0) {
    correct_by_rest(step);
  }
  if (!levelled_) {
    level(sample, step);
  } else {
    since_force_s_ += step;
    since_field_s_ += step;
    if (has_force && knows_tilt_) correct_by_force(sample.f_sensor);
    if (has_field && knows_heading_) correct_by_field(sample.m_sensor, (sample.w_sensor - bias_).norm());
  }
  bias_ = bias_.cwiseMax(-settings_.bias_limit).cwiseMin(settings_.bias_limit);
  w_ = sample.w_sensor - bias_;
  return true;
}

void AttitudeFilter::begin_levelling() {
  levelled_ = false;
  q_map_level_ = q_;
  q_level_sensor_.setIdentity();
  force_sum_.setZero();
  field_sum_.setZero();
  force_count_ = 0;
  field_count_ = 0;
  levelling_s_ = 0.0;
}

void AttitudeFilter::level(const ImuSample& sample, double dt) {
  levelling_s_ += dt;
  q_level_sensor_ = q_map_level_.conjugate() * q_;
  if (sample.f_sensor.allFinite()) {
    force_sum_ += q_level_sensor_ * sample.f_sensor;
    ++force_count_;
  }
  if (sample.m_sensor.allFinite()) {
    field_sum_ += q_level_sensor_ * sample.m_sensor;
    ++field_count_;
  }
  const Eigen::Vector3d f = force_sum_ / static_cast<double>(std::max<std::int64_t>(force_count_, 1));
  const Eigen::Vector3d m = field_sum_ / static_cast<double>(std::max<std::int64_t>(field_count_, 1));
  const Eigen::Vector3d east = m.cross(f);
  knows_tilt_ = f.norm() > kMinForce * settings_.gravity_mps2;
  knows_heading_ = knows_tilt_ && east.norm() > kMinAngle * m.norm() * f.norm();
  if (knows_heading_) {
    Eigen::Matrix3d R_level_magnetic;
    R_level_magnetic.col(0) = east.normalized();
    R_level_magnetic.col(2) = f.normalized();
    R_level_magnetic.col(1) = R_level_magnetic.col(2).cross(R_level_magnetic.col(0));
    q_map_level_ = so3::exp({0.0, 0.0, -settings_.declination}) * Eigen::Quaterniond(R_level_magnetic).conjugate();
  } else if (knows_tilt_) {
    q_map_level_ = so3::exp(tilt_of(q_map_level_ * f)) * q_map_level_;
  }
  q_ = (q_map_level_ * q_level_sensor_).normalized();
  if (levelling_s_ >= settings_.levelling_s) finish_levelling(f, m);
}

void AttitudeFilter::finish_levelling(const Eigen::Vector3d& f_level, const Eigen::Vector3d& m_level) {
  levelled_ = true;
  levelling_force_ = q_level_sensor_.conjugate() * f_level;
  if (knows_tilt_) {
    P_.topRows<2>().setZero();
    P_.leftCols<2>().setZero();
    P_.diagonal().head<2>().setConstant(square(settings_.levelling_tilt_sigma));
    restart_low_pass(q_map_level_ * f_level);
    since_restart_s_ = settings_.levelling_s;
    motion_.reset(Eigen::Matrix<double, 1, 1>::Zero());
  }
  if (knows_heading_) {
    P_.row(2).setZero();
    P_.col(2).setZero();
    P_(2, 2) = square(settings_.levelling_heading_sigma);
    field_.adopt(q_map_level_ * m_level);
    since_field_s_ = 0.0;
  }
}

/// δ ← δ − R β Δt, with β the error of the bias; noise grows with the rate.
void AttitudeFilter::predict(const Eigen::Vector3d& w_sensor, double dt) {
  const Eigen::Vector3d w = 0.5 * (last_rate_ + w_sensor) - bias_;
  last_rate_ = w_sensor;
  if (dt <= 0.0) return;
  q_ = (q_ * so3::exp(w * dt)).normalized();
  const Eigen::Matrix3d R = q_.toRotationMatrix();
  const Eigen::Matrix3d F = -R * dt;
  const Eigen::Matrix3d P_db = P_.topRightCorner<3, 3>() + F * P_.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d cross = F * P_.bottomLeftCorner<3, 3>();
  P_.topLeftCorner<3, 3>() += cross + P_db * F.transpose();
  P_.topRightCorner<3, 3>() = P_db;
  P_.bottomLeftCorner<3, 3>() = P_db.transpose();
  P_.diagonal().head<3>().array() += square(settings_.gyro_noise + settings_.gyro_noise_per_rate * w.norm()) * dt;
  P_.diagonal().tail<3>().array() += square(settings_.bias_walk) * dt;
  attitude_.step(R, dt);
}

/// What the low-pass holds was turned wrongly, too, so it starts anew.
void AttitudeFilter::lose_what_saturates(const Eigen::Vector3d& saturated_s) {
  if (saturated_s.isZero()) return;
  ++counts_.saturated;
  const Eigen::Matrix3d R = q_.toRotationMatrix();
  P_.topLeftCorner<3, 3>() += R * (square(settings_.saturation_noise) * saturated_s).asDiagonal() * R.transpose();
  since_restart_s_ = 0.0;
}

void AttitudeFilter::restart_low_pass(const Eigen::Vector3d& f_map) {
  force_.reset(f_map);
  attitude_.reset(Eigen::Matrix3d::Zero());
  since_force_s_ = 0.0;
}

/// A slow turn looks like rest. What contradicts a bias that is known already is believed only if it lasts.
void AttitudeFilter::correct_by_rest(double dt) {
  const Eigen::Vector3d residual = rest_.rate() - bias_;
  const Eigen::Array3d gate = 3.0 * (P_.diagonal().tail<3>().array() + square(settings_.rest_surprise)).sqrt();
  surprise_s_ = (residual.array().abs() > gate).any() ? surprise_s_ + dt : 0.0;
  if (surprise_s_ > 0.0 && surprise_s_ < settings_.rest_insist_s) return;
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
  H.rightCols<3>().setIdentity();
  const double variance =
      correlated(square(settings_.rest_bias_sigma), settings_.rest_time_s, dt, P_.diagonal().tail<3>().maxCoeff());
  correct<3>(H, residual, Eigen::Matrix3d::Identity() * variance, false);
}

/// z = the low-passed δ = δ + L β, L the lag of the low-pass of R: roll and pitch of it. After a restart the low-pass
/// is the mean since then until its time constant has passed, and less certain.
void AttitudeFilter::correct_by_force(const Eigen::Vector3d& f_sensor) {
  const double dt = std::max(since_force_s_, 1e-6);
  since_force_s_ = 0.0;
  since_restart_s_ += dt;
  const Eigen::Vector3d f_map = q_ * f_sensor;
  const double young = std::max(0.0, 1.0 - since_restart_s_ / settings_.accelerometer_time_s);
  if (young > 0.0) {
    restart_low_pass(force_.value() + (f_map - force_.value()) * std::min(1.0, dt / since_restart_s_));
  } else {
    force_.step(f_map, dt);
  }
  const Eigen::Matrix<double, 1, 1> squared((f_map - force_.value()).squaredNorm());
  motion_.step(squared, dt, settings_.accelerometer_time_s);

  const double g = settings_.gravity_mps2;
  const double variance = square(settings_.tilt_sigma) + square(settings_.tilt_per_motion / g) * motion_.value()(0) +
                          square(young / g) * motion_.value()(0) +
                          square(settings_.tilt_per_magnitude * (force_.value().norm() - g) / g);
  Eigen::Matrix<double, 2, 6> H = Eigen::Matrix<double, 2, 6>::Zero();
  H.leftCols<2>().setIdentity();
  H.rightCols<3>() = attitude_.lag().topRows<2>();
  const Eigen::Matrix2d R =
      Eigen::Matrix2d::Identity() * correlated(variance, settings_.acceleration_time_s, dt, tilt_variance());
  correct<2>(H, tilt_of(force_.value()).head<2>(), R, false);
}

/// z = the angle from north to the horizontal field, which an error of roll and pitch changes too: by its dip.
void AttitudeFilter::correct_by_field(const Eigen::Vector3d& m_sensor, double turn_rate) {
  const double dt = std::max(since_field_s_, 1e-6);
  since_field_s_ = 0.0;
  const Eigen::Vector3d m = q_ * m_sensor;
  const bool tilt_known = tilt_variance() < square(settings_.unknown_tilt);
  field_.step(settings_, m, dt, turn_rate > settings_.field_adopt_rate, tilt_known);
  if (!field_.usable(settings_)) {
    ++counts_.disturbed;
    return;
  }
  const double sigma =
      settings_.heading_sigma * (1.0 + settings_.heading_per_disturbance * square(field_.disturbance()));
  if (!tilt_known) {  // then the direction of the field is as good as any: Exp(δ) u = the reference's direction
    const Eigen::Vector3d u = m.normalized();
    const Eigen::Vector3d expected = so3::exp({0.0, 0.0, -settings_.declination}) *
                                     Eigen::Vector3d(0.0, std::cos(field_.dip()), -std::sin(field_.dip()));
    Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
    H.leftCols<3>() = -so3::skew(u);
    const double variance = correlated(square(sigma), settings_.heading_time_s, dt, tilt_variance());
    correct<3>(H, expected - u, Eigen::Matrix3d::Identity() * variance, false);
    return;
  }
  const double horizontal = std::max(m.head<2>().squaredNorm(), 1e-6 * m.squaredNorm());
  Eigen::Matrix<double, 1, 6> H = Eigen::Matrix<double, 1, 6>::Zero();
  H(0) = -m.x() * m.z() / horizontal;
  H(1) = -m.y() * m.z() / horizontal;
  H(2) = 1.0;
  const double residual = so3::wrap(std::atan2(m.x(), m.y()) - settings_.declination);
  const double variance = correlated(square(sigma), settings_.heading_time_s, dt, P_(2, 2));
  correct<1>(H, Eigen::Matrix<double, 1, 1>(residual), Eigen::Matrix<double, 1, 1>(variance), true);
}

/// Kalman update in Joseph form, valid for any gain; `hold_tilt` leaves roll and pitch alone. The low-passes hold the
/// past in the map frame as it was believed, so they turn along.
template <int Rows>
void AttitudeFilter::correct(const Eigen::Matrix<double, Rows, 6>& H, const Eigen::Matrix<double, Rows, 1>& residual,
                             const Eigen::Matrix<double, Rows, Rows>& R, bool hold_tilt) {
  const Eigen::Matrix<double, 6, Rows> PHt = P_ * H.transpose();
  const Eigen::Matrix<double, Rows, Rows> S = H * PHt + R;
  Eigen::Matrix<double, 6, Rows> K = PHt * S.inverse();
  if (hold_tilt) K.template topRows<2>().setZero();
  const Eigen::Matrix<double, 6, 1> x = K * residual;
  Covariance A = Covariance::Identity();
  A -= K * H;
  const Covariance P = A * P_ * A.transpose() + K * R * K.transpose();
  P_ = 0.5 * (P + P.transpose());

  const Eigen::Quaterniond turn = so3::exp(x.head<3>());
  const Eigen::Matrix3d lag = attitude_.lag();
  q_ = (turn * q_).normalized();
  bias_ += x.tail<3>();
  if (!levelled_ || !knows_tilt_) return;
  force_.turn(so3::exp(x.head<3>() + lag * x.tail<3>()).toRotationMatrix());
  attitude_.turn(turn.toRotationMatrix());
}

}  // namespace waymark::imu
