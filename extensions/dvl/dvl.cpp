// SPDX-License-Identifier: Apache-2.0
// A sensor: velocity over ground of a Doppler log (DVL) or a speed log.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "bottom_velocity.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::dvl {
namespace {

/// The velocity of the instrument, z = (1 + s) Rᵀ (v + ω × l), mounted with R at l in the base frame, along the axes
/// that it measures; s is the error of its scale, that of the speed of sound.
class VelocityUpdate final : public Update {
 public:
  VelocityUpdate(const BottomVelocity& measured, const Eigen::Vector3d& variance, const Pose& T_base_sensor, bool scale)
      : v_(measured.v_mps), variance_(variance), mounting_(T_base_sensor), has_scale_(scale) {}

  void linearize(const StateView& state, Linearization& out) const override {
    const Eigen::Matrix3d R_sensor_base = mounting_.q.toRotationMatrix().transpose();
    const double scale = has_scale_ ? 1.0 + state.block[0] : 1.0;
    const Eigen::Vector3d h = R_sensor_base * (state.nav.v_base + state.nav.w_base.cross(mounting_.p));
    const Eigen::Matrix3d by_rate = -R_sensor_base * so3::skew(mounting_.p);
    out.reset(static_cast<int>(v_.array().isFinite().count()), has_scale_ ? 1 : 0);
    for (int axis = 0, row = 0; axis < 3; ++axis) {
      if (!std::isfinite(v_[axis])) continue;
      out.residual[row] = v_[axis] - scale * h[axis];
      out.R(row, row) = variance_[axis];
      out.velocity().row(row) = scale * R_sensor_base.row(axis);
      out.angular_rate().row(row) = scale * by_rate.row(axis);
      if (has_scale_) out.block()(row, 0) = h[axis];
      ++row;
    }
  }
  Quantity observes() const override { return Quantity::velocity; }

 private:
  Eigen::Vector3d v_;
  Eigen::Vector3d variance_;
  Pose mounting_;
  bool has_scale_;
};

class Dvl final : public Sensor {
 public:
  Dvl(const Config& config, const Rig& rig)
      : T_base_sensor_(rig.T_base_sensor(config.text("name"))),
        sigma_(config.positive({"sigma_mps", "m/s", "noise per axis; the floor, whatever the device claims"}, 0.01)),
        use_reported_(config.boolean({"use_reported_sigma", "the device's own variance where it is larger"}, true)),
        max_speed_(config.positive({"max_speed_mps", "m/s", "a faster velocity is a beam's false ground"}, 5.0)),
        least_altitude_(
            config.non_negative({"least_altitude_m", "m", "nearer to the ground it measures nothing"}, 0.0)),
        still_speed_(config.non_negative(
            {"still_speed_mps", "m/s", "below this speed the vehicle counts as standing; 0: in water it never does"},
            0.0)) {
    const double sigma = config.non_negative(
        {"scale_sigma", "error of the scale (speed of sound) as a state: its first σ; 0: none"}, 0.0);
    if (sigma == 0.0) return;
    BlockState scale;
    scale.name = "scale";
    scale.initial_sigma = sigma;
    scale.walk_per_sqrt_m = config.non_negative({"scale_walk_per_sqrt_m", "1/√m", "its walk with the way"}, 0.0);
    block_.push_back(scale);
  }

  StateBlock block() const override { return block_; }
  SensorTraits traits() const override { return {.is_motion_source = true}; }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum*) const override {
    const auto& measured = measurement.as<BottomVelocity>();
    if (!unusable(measured).empty() || !measured.v_mps.allFinite()) return std::nullopt;
    ObservedMotion seen;
    seen.speed_mps = (T_base_sensor_.q * measured.v_mps).x();
    return seen;
  }

  void process(const Measurement& measurement, const Prediction&, UpdateList& out) override {
    const auto& measured = measurement.as<BottomVelocity>();
    if (const std::string_view reason = unusable(measured); !reason.empty()) {
      out.report_degraded(reason);
      return;
    }
    if (!measured.v_mps.array().isFinite().any()) throw DataError("a velocity of which no axis is known");
    out.report_motion(!(measured.v_mps.cwiseAbs().maxCoeff() < still_speed_));
    const double floor = sigma_ * sigma_;
    Eigen::Vector3d variance = Eigen::Vector3d::Constant(floor);
    if (use_reported_) {
      for (int i = 0; i < 3; ++i) {
        const double reported = measured.variance_m2ps2[i];
        if (std::isfinite(reported)) variance[i] = std::max(floor, reported);
      }
    }
    out.emplace<VelocityUpdate>(measured, variance, T_base_sensor_, !block_.empty());
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Dvl>(*this); }

 private:
  /// Why a measurement is none; empty if it is one.
  std::string_view unusable(const BottomVelocity& measured) const {
    if (!measured.locked) return "no ground in reach of the beams";
    if (measured.altitude_m < least_altitude_) return "too near to the ground";
    if ((measured.v_mps.array().abs() > max_speed_).any()) return "faster than the vehicle can be";
    return {};
  }

  Pose T_base_sensor_;
  double sigma_;
  bool use_reported_;
  double max_speed_;
  double least_altitude_;
  double still_speed_;
  StateBlock block_;
};

}  // namespace
}  // namespace waymark::dvl

WAYMARK_PLUGIN(waymark::Sensor, waymark::dvl::Dvl, "dvl", "1.0.0", waymark::dvl::BottomVelocity)
