// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "adaptive_noise.hpp"
#include "fix_continuity.hpp"
#include "fix_monitor.hpp"
#include "fix_noise.hpp"
#include "fix_position.hpp"
#include "inflation.hpp"
#include "updates.hpp"
#include "waymark/base/error.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::dgps {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// The velocity that some receivers measure by Doppler.
struct VelocitySettings {
  double sigma = 0.0;         ///< per axis [m/s]; 0: not used
  double course_sigma = 0.0;  ///< what the course errs beyond that [rad]
  double min_speed = 0.0;     ///< below it a course carries no information [m/s]
  bool gives_heading = false;
};

/// GNSS fixes, in local metres or geodetic (docs/math/dgps.md): noise per fix, quality monitoring before, soft
/// return after an outage.
class Dgps final : public Sensor {
 public:
  explicit Dgps(const Config& config)
      : lever_arm_(read_lever_arm(config)),
        noise_(config),
        offset_sigma_(noise_.usual_slow()),
        offset_vertical_sigma_(config.non_negative({"offset_vertical_sigma_m", "m",
                                                    "slowly varying error of the height, a third state (`motion.kind: "
                                                    "spatial`), beside `offset_sigma_m`; 0: none"},
                                                   0.0)),
        offset_tau_(config.positive({"offset_tau_s", "s", "time constant of the slowly varying error"}, 60.0)),
        min_satellites_(static_cast<int>(
            config.integer_in({"min_satellites", "fixes with fewer satellites count as unusable"}, 0, 100, 0))),
        velocity_(read_velocity(config)),
        sideslip_sigma_(
            config.has("sideslip_sigma_mps")
                ? config.positive(
                      {"sideslip_sigma_mps", "m/s",
                       "for a robot on wheels without odometry: with every fix, its base goes sideways by no more than "
                       "this; without it GNSS and gyro alone do not observe the heading from the course",
                       "none"})
                : 0.0),
        monitor_(config),
        settling_(config),
        reacquisition_(config),
        adaptive_(
            config.boolean({"adaptive_noise", "", "the noise grows up to 5 times in σ if the last innovations show it",
                            "true if `offset_sigma_m` is 0, else false"},
                           offset_sigma_ == 0.0)),
        horizontal_(read_window(config)),
        vertical_(horizontal_) {
    if (offset_vertical_sigma_ > 0.0 && offset_sigma_ == 0.0)
      config.fail("offset_vertical_sigma_m", "needs offset_sigma_m, the horizontal one");
  }

  StateBlock block() const override {
    if (offset_sigma_ == 0.0) return {};
    BlockState state;
    state.initial_sigma = offset_sigma_;
    state.stationary_sigma = offset_sigma_;
    state.tau_s = offset_tau_;
    StateBlock block(2, state);
    block[0].name = "offset_east_m";
    block[1].name = "offset_north_m";
    if (offset_vertical_sigma_ > 0.0) {
      state.initial_sigma = state.stationary_sigma = offset_vertical_sigma_;
      state.name = "offset_up_m";
      block.push_back(state);
    }
    return block;
  }
  /// Speed and course are a motion source: enough where there is nothing else.
  SensorTraits traits() const override {
    return {.is_motion_source = velocity_.sigma > 0.0, .is_absolute = true, .observes_height = true};
  }

  std::optional<StartHint> start_hint(const Measurement& measurement, const Datum* datum) const override {
    const auto& fix = measurement.as<GnssFix>();
    check_usable(fix, min_satellites_);
    StartHint hint;
    if (is_geodetic(fix) && datum == nullptr) {
      hint.datum = Datum{fix.latitude_deg, fix.longitude_deg, std::isfinite(fix.height_m) ? fix.height_m : 0.0};
      return hint;
    }
    hint.p_map_point = position(fix, datum);
    if (!std::isfinite(hint.p_map_point->z())) hint.p_map_point->z() = 0.0;
    hint.p_base_point = lever_arm_;
    hint.slow_sigma_m = noise_.slow(fix);
    hint.slow_tau_s = offset_tau_;
    hint.sigma_m = std::hypot(noise_.horizontal(fix), hint.slow_sigma_m);
    if (velocity_.gives_heading && has_course(fix)) {
      hint.yaw_rad = so3::wrap(0.5 * std::numbers::pi - fix.course_rad);
      hint.yaw_sigma_rad = std::hypot(velocity_.sigma / fix.speed_mps, velocity_.course_sigma, kSideslip);
    }
    return hint;
  }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum* datum) const override {
    const auto& fix = measurement.as<GnssFix>();
    check_usable(fix, min_satellites_);
    ObservedMotion seen;
    seen.ground_speed_mps = fix.speed_mps;
    seen.course_rad = so3::wrap(0.5 * std::numbers::pi - fix.course_rad);
    if (is_geodetic(fix) && datum == nullptr) return seen;
    seen.p_map_point = position(fix, datum);
    seen.p_base_point = lever_arm_;
    seen.position_sigma_m = noise_.horizontal(fix);
    seen.height_offset_sigma_m = std::max(offset_vertical_sigma_, noise_.vertical(fix));
    return seen;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    pending_ = false;
    const auto& fix = measurement.as<GnssFix>();
    check_usable(fix, min_satellites_);
    const Eigen::Vector3d p = position(fix, prediction.datum);
    const double horizontal = noise_.horizontal(fix);
    const double vertical = noise_.vertical(fix);
    const double slow = noise_.slow(fix);
    ObservedFix seen = beside_prediction(measurement.stamp, p, horizontal, slow, prediction);
    continuity_.take({.stamp = seen.stamp,
                      .z = seen.z,
                      .white_sigma = horizontal * std::sqrt(horizontal_.scale()),
                      .slow_sigma = slow,
                      .slow_tau_s = offset_tau_,
                      .speed = seen.speed,
                      .speed_sigma = seen.speed_sigma});
    seen.follows = continuity_.is_unbroken();
    if (continuity_.is_certain()) out.report_continuous();

    const double settling = settling_.factor(measurement.stamp, fix);
    if (settling > 1.0) out.report_degraded("settling after a change of fix type or satellites");
    if (const auto verdict = monitor_.judge(seen); verdict != FixMonitor::Verdict::good) {
      out.report_degraded(FixMonitor::reason(verdict));
      return;
    }
    if (horizontal_.scale() >= kDoubtedScale) out.report_degraded("residuals far beyond the stated noise");

    stated_ = {horizontal * horizontal, vertical * vertical};
    used_ = {stated_.x() * horizontal_.scale() * settling, stated_.y() * vertical_.scale() * settling};
    const Eigen::Matrix2d R = used_.x() * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d prior = seen.S - stated_.x() * Eigen::Matrix2d::Identity();
    used_ *= reacquisition_.factor(measurement.stamp, seen.innovation, prior, R);

    const bool height = !prediction.planar() && std::isfinite(p.z());
    out.emplace<PositionUpdate>(p, lever_arm_, Eigen::Vector3d(used_.x(), used_.x(), used_.y()), height ? 3 : 2,
                                offset_states(), offset_scale(slow));
    pending_ = true;
    if (velocity_.sigma > 0.0 && has_course(fix)) {
      out.emplace<VelocityUpdate>(fix.speed_mps, fix.course_rad, velocity_.sigma, velocity_.course_sigma, lever_arm_,
                                  offset_states());
    }
    if (sideslip_sigma_ > 0.0 && !prediction.standing) {
      out.emplace<SideslipUpdate>(sideslip_sigma_, offset_states());
    }
  }

  /// A rejected fix carries nothing about the noise of the others.
  void outcome(const Outcome& outcome) override {
    if (!pending_ || outcome.update != 0) return;
    pending_ = false;
    if (outcome.accepted) continuity_.accept();
    if (!adaptive_) return;
    if (!outcome.accepted) {
      horizontal_.interrupt();
      vertical_.interrupt();
      return;
    }
    const double trace = outcome.S.topLeftCorner<2, 2>().trace();
    horizontal_.take(outcome.innovation.head<2>(), trace - 2.0 * used_.x(), 2.0 * stated_.x(), 2);
    if (outcome.innovation.size() < 3) return;
    vertical_.take({outcome.innovation[2], 0.0}, outcome.S(2, 2) - used_.y(), stated_.y(), 1);
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Dgps>(*this); }
  void save(OutArchive& out) const override { out(*this); }
  void load(InArchive& in) override { in(*this); }
  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("dgps", 2) < 2) throw DataError("dgps: the checkpoint has an older version");
    archive(continuity_, monitor_, settling_, reacquisition_, horizontal_, vertical_, pending_, stated_, used_);
  }

 private:
  /// Twice the stated σ: either the fixes are worse than they state or the belief is off, and nothing here can decide
  /// which.
  static constexpr double kDoubtedScale = 4.0;
  static constexpr double kSideslip = 10.0 * kDegree;  // a vehicle does not drive exactly where it points

  static Eigen::Vector3d read_lever_arm(const Config& config) {
    // An antenna a metre off the axle makes a metre of error: the YAML must say where it is, or that it does not
    // matter.
    const Config::Key key{"base_p_antenna_m", "m", "lever arm: the antenna in the base frame [x, y, z], or `none`"};
    if (!config.is_list(key.name) && config.has(key.name)) {
      config.choice(key, {"none"});
      return Eigen::Vector3d::Zero();
    }
    const auto arm = config.numbers(key, 3);
    return {arm[0], arm[1], arm[2]};
  }

  static VelocitySettings read_velocity(const Config& config) {
    VelocitySettings velocity;
    if (!config.has("velocity_sigma_mps")) return velocity;
    velocity.sigma = config.positive(
        {"velocity_sigma_mps", "m/s", "noise per axis of speed and course; without it they are not used", "none"});
    velocity.course_sigma =
        kDegree *
        config.number_in({"course_sigma_deg", "°", "error of the course beyond `velocity_sigma_mps`"}, 0.0, 90.0, 0.0);
    velocity.min_speed =
        config.positive({"velocity_min_mps", "m/s", "below this speed the course carries no information"}, 1.0);
    const Config::Key heading{"heading_from_course",
                              "the first course is the start's heading; false for a robot that may begin in reverse"};
    const Config::Key old_heading{"course_tells_heading", "old name of `heading_from_course`"};
    const bool has_old_name = config.has(old_heading) && !config.has(heading);
    velocity.gives_heading = config.boolean(has_old_name ? old_heading : heading, true);
    return velocity;
  }

  static AdaptiveNoise read_window(const Config& config) {
    return AdaptiveNoise(static_cast<int>(
        config.integer_in({"adaptive_window", "number of innovations that `adaptive_noise` takes into account"}, 5,
                          AdaptiveNoise::kMaxWindow, 20)));
  }

  int offset_states() const {
    if (offset_sigma_ == 0.0) return 0;
    return offset_vertical_sigma_ == 0.0 ? 2 : 3;
  }

  double offset_scale(double slow_sigma) const { return offset_sigma_ > 0.0 ? slow_sigma / offset_sigma_ : 1.0; }

  bool has_course(const GnssFix& fix) const {
    return std::isfinite(fix.speed_mps) && std::isfinite(fix.course_rad) && fix.speed_mps >= velocity_.min_speed;
  }

  /// The fix beside what the mixture expects. The offset counts with its whole stationary uncertainty, not with what is
  /// left of it: the monitor had rather doubt too little.
  ObservedFix beside_prediction(Time stamp, const Eigen::Vector3d& p, double sigma, double slow_sigma,
                                const Prediction& prediction) const {
    const double variance = sigma * sigma + slow_sigma * slow_sigma;
    const PositionUpdate model(p, lever_arm_, Eigen::Vector3d::Constant(variance), 2, 0);
    const PredictedInnovation innovation = prediction.innovation(model);
    const NavState& state = prediction.belief.mean;
    ObservedFix seen;
    seen.stamp = stamp;
    seen.z = p.head<2>();
    seen.innovation = innovation.nu;
    if (offset_sigma_ > 0.0)
      seen.innovation -= offset_scale(slow_sigma) * Eigen::Map<const Eigen::Vector2d>(prediction.block);
    seen.S = innovation.S;
    seen.sigma = std::sqrt(variance);
    const Eigen::Vector3d v = state.v_base + state.w_base.cross(lever_arm_);
    seen.speed = (state.T_map_base.q * v).head<2>().norm();
    seen.speed_sigma = std::sqrt(std::max(0.0, prediction.velocity_variance().x()));
    seen.standing = prediction.standing;
    return seen;
  }

  Eigen::Vector3d lever_arm_;
  FixNoise noise_;
  double offset_sigma_;
  double offset_vertical_sigma_;
  double offset_tau_;
  int min_satellites_;
  VelocitySettings velocity_;
  double sideslip_sigma_;

  FixContinuity continuity_;
  FixMonitor monitor_;
  Settling settling_;
  Reacquisition reacquisition_;
  bool adaptive_;
  AdaptiveNoise horizontal_;
  AdaptiveNoise vertical_;
  bool pending_ = false;                              // the outcome of a position is still to come
  Eigen::Vector2d stated_ = Eigen::Vector2d::Zero();  // variance of the last fix, horizontal and vertical
  Eigen::Vector2d used_ = Eigen::Vector2d::Zero();    // the same as given to the filter
};

}  // namespace

}  // namespace waymark::dgps

WAYMARK_PLUGIN(waymark::Sensor, waymark::dgps::Dgps, "dgps", "1.1.0")
