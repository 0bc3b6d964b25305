// SPDX-License-Identifier: Apache-2.0
// A sensor: odometry of a camera or a LIDAR, as relative poses with covariance. Where its track is lost or its frame
// jumps the robot goes on as it moved.
#include "relative_pose.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "twist.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::relative {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180.0;

/// The twist of the base, z = (v, ω) + noise; in the plane v_x, v_y and ω_z.
class TwistUpdate final : public Update {
 public:
  TwistUpdate(const Twist& twist, bool planar) : twist_(twist), planar_(planar) {}

  void linearize(const StateView& state, Linearization& out) const override {
    Vector6 h;
    h << state.nav.v_base, state.nav.w_base;
    const auto rows = planar_ ? std::array{0, 1, 5, -1, -1, -1} : std::array{0, 1, 2, 3, 4, 5};
    const int count = planar_ ? 3 : 6;
    out.reset(count, 0);
    for (int i = 0; i < count; ++i) {
      const int row = rows[static_cast<std::size_t>(i)];
      out.residual[i] = twist_.mean[row] - h[row];
      for (int j = 0; j < count; ++j) out.R(i, j) = twist_.covariance(row, rows[static_cast<std::size_t>(j)]);
      (row < 3 ? out.velocity() : out.angular_rate())(i, row % 3) = 1.0;
    }
  }
  Quantity observes() const override { return Quantity::velocity; }

 private:
  Twist twist_;
  bool planar_;
};

class RelativePoseSensor final : public Sensor {
 public:
  RelativePoseSensor(const Config& config, const Rig& rig)
      : T_base_sensor_(rig.T_base_sensor(config.text("name"))),
        noise_{
            config.positive({"position_noise_m_per_sqrt_s", "m/√s", "noise of positions without a reported σ"}, 0.02),
            kRadPerDegree * config.positive({"rotation_noise_deg_per_sqrt_s", "°/√s", "the same of rotations"}, 0.3),
            config.boolean({"use_reported_sigma", "the odometry's own σ, where it gives one"}, true)},
        limits_{config.positive({"max_speed_mps", "m/s", "the vehicle is not faster: beyond it the frame has jumped"}),
                kRadPerDegree * config.positive({"max_rate_degps", "°/s", "it does not turn faster"}),
                config.positive({"max_acceleration_mps2", "m/s²", "it does not accelerate more"}),
                kRadPerDegree * config.positive({"max_angular_acceleration_degps2", "°/s²", "nor in its rotation"})},
        still_speed_(
            config.non_negative({"still_speed_mps", "m/s", "below it, and below `still_rate_degps`, it stands"}, 0.01)),
        still_rate_(kRadPerDegree *
                    config.non_negative({"still_rate_degps", "°/s", "below it, and below `still_speed_mps`, it stands"},
                                        0.5)) {}

  SensorTraits traits() const override { return {.is_motion_source = true}; }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum*) const override {
    const Twist twist = twist_of(measurement, T_base_sensor_, noise_);
    if (!limits_.allow(twist)) return std::nullopt;
    ObservedMotion seen;
    seen.speed_mps = twist.mean[0];
    seen.yaw_rate_radps = twist.mean[5];
    seen.interval_s = twist.interval_s;
    return seen;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    Twist twist = twist_of(measurement, T_base_sensor_, noise_);
    const double elapsed = last_ ? to_seconds(measurement.stamp - stamp_) + 0.5 * twist.interval_s : 0.0;
    if (limits_.allow(twist) && (!last_ || limits_.allow_change(*last_, twist, elapsed))) {
      last_ = twist;
      stamp_ = measurement.stamp + from_seconds(0.5 * twist.interval_s);  // a mean is true in the middle
      out.report_motion(twist.mean.head<3>().norm() > still_speed_ || twist.mean.tail<3>().norm() > still_rate_);
    } else {
      out.report_degraded(twist.tracked ? "the odometry's frame jumped" : "the odometry lost its track");
      if (!last_) return;
      twist = limits_.extrapolate(*last_, elapsed);
    }
    // The twist of this interval is independent of what was known of the one before.
    constexpr double kFar = 1e3;
    const double widest = std::sqrt(twist.covariance.diagonal().maxCoeff());
    out.reset_twist({std::max(100.0, kFar * widest), std::max(100.0, kFar * widest)});
    out.emplace<TwistUpdate>(twist, prediction.planar());
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<RelativePoseSensor>(*this); }
  void save(OutArchive& out) const override { out(*this); }
  void load(InArchive& in) override { in(*this); }
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("relative_pose", 1);
    archive(last_, stamp_);
  }

 private:
  Pose T_base_sensor_;
  IncrementNoise noise_;
  Limits limits_;
  double still_speed_;
  double still_rate_;
  std::optional<Twist> last_;  // that was believed
  Time stamp_{};               // of the middle of its interval
};

}  // namespace
}  // namespace waymark::relative

WAYMARK_PLUGIN(waymark::Sensor, waymark::relative::RelativePoseSensor, "relative_pose", "1.0.0",
               waymark::relative::RelativePose)
