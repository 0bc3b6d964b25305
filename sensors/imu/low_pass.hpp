// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace waymark::imu {

/// First-order low-pass of a vector or matrix: time constant [s], exact for an input held over each interval, so the
/// sampling rate may vary.
template <class Value>
class FirstOrderLowPass {
 public:
  void reset(const Value& value) { value_ = value; }
  void step(const Value& input, double dt, double time_constant) {
    value_ += (input - value_) * -std::expm1(-dt / time_constant);
  }
  const Value& value() const { return value_; }
  template <class Archive>
  void serialize(Archive& archive) {
    archive(value_);
  }

 private:
  Value value_ = Value::Zero();
};

/// Second-order Butterworth low-pass of a matrix, x'' + √2 ω x' + ω² x = ω² u with ω = √2 / time constant: the step
/// response settles like a first-order one of that time constant. Exact for an input held over each interval.
template <class Value>
class ButterworthLowPass {
 public:
  explicit ButterworthLowPass(double time_constant) : omega_(std::sqrt(2.0) / time_constant) {}

  void reset(const Value& value) {
    x_ = value;
    rate_.setZero();
  }
  /// The closed solution of the free motion of e = x − u over `dt` [s]; the poles are ω/√2 (−1 ± i).
  void step(const Value& input, double dt) {
    const double a = omega_ / std::sqrt(2.0);
    const double decay = std::exp(-a * dt);
    const double c = decay * std::cos(a * dt);
    const double s = decay * std::sin(a * dt);
    const Value e = x_ - input;
    const Value old_rate = rate_;
    x_ = input + e * (c + s) + old_rate * (s / a);
    rate_ = old_rate * (c - s) - e * (2.0 * a * s);
  }
  /// Turns the whole history: `left` is multiplied from the left.
  void turn(const Eigen::Matrix3d& left) {
    x_ = (left * x_).eval();
    rate_ = (left * rate_).eval();
  }
  const Value& value() const { return x_; }
  /// ∫ (input − value) dt since the reset: how far the output lags behind the integral of the input.
  Value lag() const { return (rate_ + std::sqrt(2.0) * omega_ * x_) / (omega_ * omega_); }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(x_, rate_);
  }

 private:
  double omega_;
  Value x_ = Value::Zero();
  Value rate_ = Value::Zero();
};

}  // namespace waymark::imu
