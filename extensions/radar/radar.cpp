// SPDX-License-Identifier: Apache-2.0
// A sensor: velocity and yaw rate of the base from the Doppler of a radar's static targets.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "ego_velocity.hpp"
#include "radar_settings.hpp"
#include "radar_updates.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::radar {
namespace {

class Radar final : public Sensor {
 public:
  Radar(const Config& config, const Rig& rig)
      : settings_(RadarSettings::read(config)),
        estimator_(settings_.scan),
        T_base_sensor_(rig.T_base_sensor(config.text("name"))) {}

  StateBlock block() const override { return settings_.block(); }
  SensorTraits traits() const override { return {.is_motion_source = true}; }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum*) const override {
    const EgoVelocity& velocity = scanned(measurement);
    if (!estimator_.believed(velocity)) return std::nullopt;
    const Eigen::Vector3d v_base = T_base_sensor_.q * velocity.v;
    const Eigen::Vector3d& l = T_base_sensor_.p;
    ObservedMotion seen;
    // One radar does not see the rate; the axle does, which does not move sideways: v_y = ω (l_x − k v_x²).
    double rate = 0.0;
    if (settings_.rear_axle) {
      const double lever = l.x() - settings_.rear_axle->slip * v_base.x() * v_base.x();
      if (std::abs(lever) > kLeastLever) {
        rate = v_base.y() / lever;
        seen.yaw_rate_radps = rate;
      }
    }
    seen.speed_mps = v_base.x() + rate * l.y();
    return seen;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    const EgoVelocity& velocity = scanned(measurement);
    const double dt = interval(measurement.stamp);
    last_stamp_ = measurement.stamp;
    if (!estimator_.believed(velocity)) {
      out.report_degraded("too few targets agree on a velocity");
      return;
    }
    out.report_motion(velocity.v.norm() > settings_.still_speed_mps);
    const double times = std::max(1.0, 2.0 * settings_.error_time_s / dt);
    const Eigen::Matrix3d R = velocity.white + times * velocity.shared;
    out.emplace<VelocityUpdate>(velocity.v, R, settings_.scan.dimensions, T_base_sensor_, settings_.index());
    if (settings_.rear_axle) {
      const RearAxle& axle = *settings_.rear_axle;
      const double density = axle.noise + axle.noise_per_speed * std::abs(prediction.belief.mean.v_base.x());
      out.emplace<RearAxleUpdate>(density * density / dt, axle.slip, settings_.index());
    }
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Radar>(*this); }
  void save(OutArchive& out) const override { out(*this); }
  void load(InArchive& in) override { in(*this); }
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("radar", 1);
    archive(last_stamp_);
  }

 private:
  /// The velocity from this scan: the same for `observed_motion` and `process`, and computed once.
  const EgoVelocity& scanned(const Measurement& measurement) const {
    if (measurement.payload == scan_ && measurement.stamp == stamp_) return velocity_;
    const auto& targets = measurement.as<RadarTargets>().targets;
    velocity_ =
        estimator_.estimate(targets, Random({0, 0, measurement.stamp.time_since_epoch().count(), measurement.sensor}));
    scan_ = measurement.payload;
    stamp_ = measurement.stamp;
    return velocity_;
  }

  /// Since the scan before: what the noise of this one stands for [s].
  double interval(Time stamp) const {
    const double since = last_stamp_ ? to_seconds(stamp - *last_stamp_) : kMostInterval;
    return std::clamp(since, kLeastInterval, kMostInterval);
  }

  static constexpr double kLeastInterval = 1e-2;  // [s], two scans with one stamp
  static constexpr double kMostInterval = 0.5;    // [s], a scan does not stand for more than this
  static constexpr double kLeastLever = 0.5;      // [m], below it the axle says nothing about the rate

  RadarSettings settings_;
  mutable EgoVelocityEstimator estimator_;  // has room for a scan, and no memory of one
  Pose T_base_sensor_;
  std::optional<Time> last_stamp_;
  mutable std::shared_ptr<const Payload> scan_;  // what `velocity_` was computed from
  mutable Time stamp_{};
  mutable EgoVelocity velocity_;
};

}  // namespace
}  // namespace waymark::radar

WAYMARK_PLUGIN(waymark::Sensor, waymark::radar::Radar, "radar", "1.0.0")
