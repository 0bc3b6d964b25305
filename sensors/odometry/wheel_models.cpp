// SPDX-License-Identifier: Apache-2.0
#include "wheel_models.hpp"

#include <fmt/format.h>

#include <cmath>

#include "waymark/interface/payloads.hpp"

namespace waymark::odometry {

namespace {

/// Where the geometry is not given: wheels that differ by 2.5 % on a track of 0.8 m [1/m].
constexpr double kUnknownVehicle = 0.03;

class Differential final : public WheelModel {
 public:
  explicit Differential(const Config& config)
      : track_(config.positive({"track_m", "m", "differential: distance between the wheels"})) {}
  WheelTwist twist(const Measurement& measurement) const override {
    const auto& wheels = measurement.as<WheelSpeeds>();
    return {0.5 * (wheels.left_mps + wheels.right_mps), 0.0, (wheels.right_mps - wheels.left_mps) / track_};
  }
  bool rotation_scales_with_speed() const override { return true; }
  bool has_wheels() const override { return true; }
  /// Wheels with 0.01 m/√s and 1 % of their speed each: the narrower the track, the worse.
  std::vector<double> usual_yaw_noise() const override { return {0.015 / track_, 0.015 / track_, 0.2}; }
  /// Wheels whose radii differ by 2.5 % (σ).
  double usual_curvature_sigma() const override { return 0.025 / track_; }

 private:
  double track_;
};

/// Bicycle model with the encoder on one rear wheel: v = v_wheel / (1 − tan(steering) h / L), ω = v tan(steering) / L
/// (J. Guivant, E. Nebot, IEEE T-RA 17(3), 2001).
class Ackermann final : public WheelModel {
 public:
  explicit Ackermann(const Config& config)
      : wheelbase_(config.positive({"wheelbase_m", "m", "ackermann: distance between the axles"})),
        encoder_left_(
            config.number({"encoder_left_m", "m",
                           "ackermann: the wheel with the encoder, left of the rear axle's centre (negative: right)"},
                          0.0)) {}
  WheelTwist twist(const Measurement& measurement) const override {
    const auto& wheel = measurement.as<WheelSteering>();
    const double curvature = std::tan(wheel.steering_rad) / wheelbase_;
    const double v = wheel.speed_mps / (1.0 - curvature * encoder_left_);
    return {v, 0.0, v * curvature};
  }
  bool rotation_scales_with_speed() const override { return true; }
  bool has_wheels() const override { return true; }
  /// A car turns by its steering, which is measured, not by the difference of two wheels.
  std::vector<double> usual_yaw_noise() const override { return {0.0, 0.01, 0.05}; }
  /// A steering offset of 1.1° (σ).
  double usual_curvature_sigma() const override { return 0.02 / wheelbase_; }

 private:
  double wheelbase_;
  double encoder_left_;
};

class ReadyTwist final : public WheelModel {
 public:
  WheelTwist twist(const Measurement& measurement) const override {
    const auto& twist = measurement.as<BodyTwist>();
    return {twist.v_x_mps, twist.v_y_mps, twist.w_z_radps};
  }
  bool rotation_scales_with_speed() const override { return false; }
  double usual_curvature_sigma() const override { return kUnknownVehicle; }
};

/// The constant twist that moves the base as far in the interval: the logarithm of the motion, by the interval.
class Increment final : public WheelModel {
 public:
  WheelTwist twist(const Measurement& measurement) const override {
    const auto& step = measurement.as<PoseIncrement>();
    if (!(step.interval_s > 0.0) || !std::isfinite(step.interval_s))
      throw DataError(fmt::format("PoseIncrement: interval_s is {}, a number > 0 is expected", step.interval_s));
    // The arc's chord is sin(h)/h as long as the arc and turned by h, half the turn.
    const double half = 0.5 * step.yaw_rad;
    const double along = std::abs(half) < 1e-4 ? 1.0 - half * half / 3.0 : half / std::tan(half);
    const double rate = 1.0 / step.interval_s;
    return {rate * (along * step.x_m + half * step.y_m), rate * (along * step.y_m - half * step.x_m),
            rate * step.yaw_rad, step.interval_s};
  }
  bool rotation_scales_with_speed() const override { return false; }
  double usual_curvature_sigma() const override { return kUnknownVehicle; }
};

}  // namespace

std::shared_ptr<const WheelModel> WheelModel::read(const Config& config) {
  const std::string model = config.choice({"model",
                                           "`differential` takes `WheelSpeeds`, `ackermann` `WheelSteering`, `twist` "
                                           "`BodyTwist`, `increment` `PoseIncrement`"},
                                          {"differential", "ackermann", "twist", "increment"});
  if (model == "differential") return std::make_shared<Differential>(config);
  if (model == "ackermann") return std::make_shared<Ackermann>(config);
  if (model == "increment") return std::make_shared<Increment>();
  return std::make_shared<ReadyTwist>();
}

}  // namespace waymark::odometry
