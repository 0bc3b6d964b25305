// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "waymark/plugin/sensor.hpp"
#include "wheel_models.hpp"

namespace waymark::odometry {

namespace {

/// A noise density that grows with motion: floor + per_speed·|v| + per_rate·|ω|, in [unit/√s].
struct Density {
  double floor = 0.0;
  double per_speed = 0.0;
  double per_rate = 0.0;
  double at(const WheelTwist& twist) const {
    return floor + per_speed * std::hypot(twist.v_x, twist.v_y) + per_rate * std::abs(twist.w_z);
  }
};

Density read_density(const Config& config, const Config::Key& key, const std::vector<double>& fallback) {
  const auto values = config.numbers(key, static_cast<int>(fallback.size()), fallback);
  for (const double value : values) {
    if (value < 0.0) config.fail(key.name, "must be >= 0 in every place");
  }
  return {values[0], values[1], values.size() > 2 ? values[2] : 0.0};
}

/// Errors that stay: each has a known value, and is a state of the sensor's block if its sigma is not zero.
struct Systematic {
  enum Kind { kSpeedScale, kCurvature, kYawScale, kTurnLoss, kCount };
  std::array<int, kCount> index{-1, -1, -1, -1};  // within the block
  std::array<double, kCount> known{};
  StateBlock block;

  void add(Kind kind, const char* name, double value, double sigma, double walk_per_sqrt_m) {
    known[kind] = value;
    if (sigma == 0.0 && walk_per_sqrt_m == 0.0) return;
    index[kind] = static_cast<int>(block.size());
    BlockState state;
    state.name = name;
    state.initial = value;
    state.initial_sigma = sigma;
    state.walk_per_sqrt_m = walk_per_sqrt_m;
    block.push_back(state);
  }
  /// σ of an error that the configuration counts as usual.
  double usual(Kind kind, double at_least) const {
    return index[kind] < 0 ? at_least : std::max(at_least, block[static_cast<std::size_t>(index[kind])].initial_sigma);
  }
  double value(const double* states, Kind kind) const { return index[kind] < 0 ? known[kind] : states[index[kind]]; }
};

/// Nothing if the YAML says `none`, or says nothing of a robot that need not have wheels.
std::optional<Density> read_vertical(const Config& config, bool has_wheels) {
  const Config::Key key{"vertical_noise_m_per_sqrt_s", "m/√s",
                        "noise density [a, b] of the motion along the base's z axis, which is observed as 0: wheels "
                        "stay on the ground; a + b · speed. `none`: not observed. For `motion.kind: spatial`",
                        "differential, ackermann [0, 0.05], else `none`"};
  if (config.is_word(key, "none") || (!has_wheels && !config.has(key))) {
    if (config.has(key)) config.choice(key, {"none"});
    return std::nullopt;
  }
  return read_density(config, key, {0.0, 0.05});
}

/// The share of its speed that a robot keeps in a turn if it loses `loss` [m] times the rate: it stops, but does not
/// reverse.
double kept_in_turn(const WheelTwist& twist, double loss) {
  if (loss == 0.0) return 1.0;
  const double speed = std::hypot(twist.v_x, twist.v_y);
  return speed > 0.0 ? std::max(0.0, 1.0 - loss * std::abs(twist.w_z) / speed) : 1.0;
}

/// The twist that the wheels give, as a measurement of the body twist: v = (1 + s) v_w, ω = (1 + s)(1 + s_yaw) ω_w + κ
/// v_w with scale s, yaw scale s_yaw and curvature κ out of the block (s leaves ω alone where the rotation is measured
/// otherwise); of v_w a loss in turns is taken off. In space also v_z = 0, if a variance is given for it.
class TwistUpdate final : public Update {
 public:
  TwistUpdate(const WheelTwist& twist, const Eigen::Vector3d& variance, std::optional<double> vertical_variance,
              const Systematic& systematic, bool scale_rotation)
      : twist_(twist),
        variance_(variance),
        vertical_variance_(vertical_variance),
        systematic_(systematic),
        scale_rotation_(scale_rotation) {}

  void linearize(const StateView& state, Linearization& out) const override {
    const double scale = 1.0 + systematic_.value(state.block, Systematic::kSpeedScale);
    const double turn_scale = 1.0 + systematic_.value(state.block, Systematic::kYawScale);
    const double curvature = systematic_.value(state.block, Systematic::kCurvature);
    const double rotation_scale = scale_rotation_ ? scale : 1.0;
    const double kept = kept_in_turn(twist_, systematic_.value(state.block, Systematic::kTurnLoss));
    const double v_x = kept * twist_.v_x;
    const double v_y = kept * twist_.v_y;

    out.reset(vertical_variance_ ? 4 : 3, static_cast<int>(systematic_.block.size()));
    out.residual.head<3>() << scale * v_x - state.nav.v_base.x(), scale * v_y - state.nav.v_base.y(),
        rotation_scale * turn_scale * twist_.w_z + curvature * v_x - state.nav.w_base.z();
    out.R.diagonal().head<3>() = variance_;
    auto& velocity = out.velocity();
    velocity(0, 0) = 1.0;
    velocity(1, 1) = 1.0;
    out.angular_rate()(2, 2) = 1.0;
    if (vertical_variance_) {
      out.residual(3) = -state.nav.v_base.z();
      out.R(3, 3) = *vertical_variance_;
      velocity(3, 2) = 1.0;
    }
    if (systematic_.block.empty()) return;
    // The states correct the measurement, so their Jacobian is that of −z. Odometry alone does not observe its own
    // scale: estimated here, it would follow the noise of z.
    out.mark_block_considered();
    auto& block = out.block();
    if (const int k = systematic_.index[Systematic::kSpeedScale]; k >= 0) {
      block(0, k) = -v_x;
      block(1, k) = -v_y;
      if (scale_rotation_) block(2, k) = -turn_scale * twist_.w_z;
    }
    if (const int k = systematic_.index[Systematic::kCurvature]; k >= 0) block(2, k) = -v_x;
    if (const int k = systematic_.index[Systematic::kYawScale]; k >= 0) block(2, k) = -rotation_scale * twist_.w_z;
    if (const int k = systematic_.index[Systematic::kTurnLoss]; k >= 0 && kept > 0.0) {
      const double speed = std::hypot(twist_.v_x, twist_.v_y);
      const double rate = speed > 0.0 ? std::abs(twist_.w_z) / speed : 0.0;
      block(0, k) = scale * rate * twist_.v_x;
      block(1, k) = scale * rate * twist_.v_y;
      block(2, k) = curvature * rate * twist_.v_x;
    }
  }

 private:
  WheelTwist twist_;
  Eigen::Vector3d variance_;
  std::optional<double> vertical_variance_;
  const Systematic& systematic_;  // of the sensor, which outlives its updates
  bool scale_rotation_;
};

/// Wheel odometry as a relative sensor (docs/math/ekf.md, "Odometry"): noise as densities, so that halving the rate
/// does not change how fast the pose's covariance grows.
class Odometry final : public Sensor {
 public:
  explicit Odometry(const Config& config)
      : model_(WheelModel::read(config)),
        speed_(read_density(config,
                            {"speed_noise_m_per_sqrt_s", "m/√s", "noise density [a, b] of the speed: a + b · speed"},
                            {0.02, 0.05})),
        lateral_(
            read_density(config,
                         {"lateral_noise_m_per_sqrt_s", "m/√s",
                          "noise density [a, b] of sideways slip: a + b · speed; zero is wrong for every real vehicle"},
                         {0.0, 0.1})),
        yaw_(read_density(
            config,
            {"yaw_noise_rad_per_sqrt_s", "rad/√s", "noise density [a, b, c] of the rotation: a + b · speed + c · rate",
             "differential [0.015/`track_m`, the same, 0.2], ackermann [0, 0.01, 0.05], else [0.03, 0.03, 0.2]"},
            model_->usual_yaw_noise())),
        vertical_(read_vertical(config, model_->has_wheels())),
        still_speed_(config.non_negative(
            {"still_speed_mps", "m/s", "below this speed, and below `still_rate_radps`, the robot counts as standing"},
            0.01)),
        still_rate_(config.non_negative(
            {"still_rate_radps", "rad/s", "below this rate, and below `still_speed_mps`, the robot counts as standing"},
            0.01)),
        max_interval_(config.positive(
            {"max_interval_s", "s",
             "a sample does not stand for more than this: what a gap in the log means; of `increment`: in a longer "
             "interval the robot stood for what its motion leaves over at 0.1 m/s and 0.1 rad/s, without noise"},
            0.5)) {
    if (speed_.floor == 0.0 && speed_.per_speed == 0.0)
      config.fail("speed_noise_m_per_sqrt_s", "a speed without noise is not believable");
    systematic_.add(
        Systematic::kSpeedScale, "speed_scale",
        config.positive({"speed_scale", "", "true speed per speed that the wheels give"}, 1.0) - 1.0,
        config.non_negative(
            {"speed_scale_sigma", "scale error of the wheels as a state: its first σ; 0, and no walk: no state"}, 0.02),
        config.non_negative({"speed_scale_walk_per_sqrt_m", "1/√m", "walk of the wheels' scale error with distance"},
                            0.0));
    systematic_.add(
        Systematic::kCurvature, "curvature_per_m",
        config.number({"curvature_per_m", "1/m", "rotation per metre that the wheels do not give; left positive"}, 0.0),
        config.non_negative(
            {"curvature_sigma_per_m", "1/m",
             "a steering offset (a robot that pulls to one side) as a state: its first σ; 0, and no walk: no state",
             "0.025/`track_m`, 0.02/`wheelbase_m`, else 0.03"},
            model_->usual_curvature_sigma()),
        config.non_negative({"curvature_walk_per_m_sqrt_m", "1/m/√m", "walk of the steering offset with distance"},
                            0.0));
    systematic_.add(
        Systematic::kYawScale, "yaw_scale",
        config.positive({"yaw_scale", "", "true rotation per rotation that the wheels give, beside `speed_scale`"},
                        1.0) -
            1.0,
        config.non_negative(
            {"yaw_scale_sigma", "scale error of the rotation as a state: its first σ; 0, and no walk: no state"}, 0.03),
        config.non_negative({"yaw_scale_walk_per_sqrt_m", "1/√m", "walk of the rotation's scale error with distance"},
                            0.0));
    systematic_.add(
        Systematic::kTurnLoss, "turn_loss_m",
        config.non_negative(
            {"turn_loss_m", "m",
             "forward speed that is lost in turns, per rate of turn: of skid-steered wheels, or of commands that a "
             "robot obeys with its outer wheel; it stops, but does not reverse"},
            0.0),
        config.non_negative({"turn_loss_sigma_m", "m", "error of `turn_loss_m` as a state: its first σ; 0: no state"},
                            0.0),
        0.0);
  }

  StateBlock block() const override { return systematic_.block; }
  SensorTraits traits() const override { return {.is_motion_source = true, .observes_height = vertical_.has_value()}; }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum*) const override {
    WheelTwist twist = model_->twist(measurement);
    ObservedMotion seen;
    const double scale = 1.0 + systematic_.known[Systematic::kSpeedScale];
    const double kept = kept_in_turn(twist, systematic_.known[Systematic::kTurnLoss]);
    twist.v_x *= kept;
    twist.v_y *= kept;
    seen.speed_mps = scale * twist.v_x;
    seen.lateral_speed_mps = scale * twist.v_y;
    // So much noise is the way to declare that the rotation is not measured.
    if (yaw_.floor < kNoRotation) {
      seen.yaw_rate_radps = (model_->rotation_scales_with_speed() ? scale : 1.0) *
                                (1.0 + systematic_.known[Systematic::kYawScale]) * twist.w_z +
                            systematic_.known[Systematic::kCurvature] * twist.v_x;
    }
    seen.interval_s = twist.interval_s.value_or(0.0);
    seen.speed_scale_sigma = systematic_.usual(Systematic::kSpeedScale, seen.speed_scale_sigma);
    // Noise that grows with the rate, more than by default, is what a skid-steered robot has instead of a scale.
    const double noise_per_rate = yaw_.per_rate > model_->usual_yaw_noise().back() ? yaw_.per_rate : 0.0;
    seen.yaw_scale_sigma =
        std::hypot(systematic_.usual(Systematic::kYawScale, seen.yaw_scale_sigma), kScaleOfNoise * noise_per_rate);
    seen.curvature_sigma_per_m = systematic_.usual(Systematic::kCurvature, model_->usual_curvature_sigma());
    seen.yaw_scales_with_speed = model_->rotation_scales_with_speed();
    return seen;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    const WheelTwist twist = model_->twist(measurement);
    out.report_motion(std::hypot(twist.v_x, twist.v_y) > still_speed_ || std::abs(twist.w_z) > still_rate_);
    const Eigen::Vector4d variances = twist.interval_s ? variance_over(twist, *twist.interval_s)
                                                       : variance_at(twist, measurement.stamp, prediction.belief.mean);
    const Eigen::Vector3d variance = variances.head<3>();
    last_stamp_ = std::max(last_stamp_.value_or(measurement.stamp), measurement.stamp);
    if (twist.interval_s) out.reset_twist(unknown_beside(twist, variance, prediction.belief.mean));
    const bool observes_vertical = vertical_ && !prediction.planar();
    out.emplace<TwistUpdate>(twist, variance, observes_vertical ? std::optional(variances.w()) : std::nullopt,
                             systematic_, model_->rotation_scales_with_speed());
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Odometry>(*this); }
  void save(OutArchive& out) const override { out(*this); }
  void load(InArchive& in) override { in(*this); }
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("odometry", 1);
    archive(last_stamp_);
  }

 private:
  /// Of a sample of the twist, which stands for the time since the sample before.
  Eigen::Vector4d variance_at(const WheelTwist& twist, Time stamp, const NavState& predicted) const {
    const double interval = last_stamp_ ? to_seconds(stamp - *last_stamp_) : kFirstInterval;
    const bool continues = last_stamp_ && interval <= max_interval_;
    const double dt = std::clamp(interval, kMinInterval, max_interval_);
    // The noise belongs to the motion, not to the reading: if a reading that is too large got more noise than one that
    // is too small, turns would come out too small on the average.
    const WheelTwist motion =
        continues ? WheelTwist{predicted.v_base.x(), predicted.v_base.y(), predicted.w_base.z()} : twist;
    return variance(motion) / dt;
  }

  /// Of the mean twist of an interval: what the densities make of its motion, by the interval's square. In a long one
  /// the robot stood for what its motion leaves over at kSlow and kSlowTurn, and that time has no noise. Stamps jitter,
  /// and the same motion in half the time has not twice the noise: no interval counts as shorter than kShortest.
  Eigen::Vector4d variance_over(const WheelTwist& twist, double interval) const {
    const double at_slow = std::hypot(twist.v_x, twist.v_y) / kSlow + std::abs(twist.w_z) / kSlowTurn;
    const double moving = std::clamp(interval * at_slow, std::min(interval, max_interval_), interval);
    const double taken = std::max(moving, kShortest);
    const double faster = interval / taken;
    const WheelTwist motion{faster * twist.v_x, faster * twist.v_y, faster * twist.w_z};
    return variance(motion) * taken / (interval * interval);
  }

  /// The squares of the densities: forwards, sideways, yaw, along z.
  Eigen::Vector4d variance(const WheelTwist& motion) const {
    const auto square = [&](const Density& density) {
      const double d = std::max(density.at(motion), kMinDensity);
      return d * d;
    };
    return {square(speed_), square(lateral_), square(yaw_), square(vertical_.value_or(Density{}))};
  }

  /// So wide that neither the gain nor the gate depends on the twist before.
  static UpdateList::UnknownTwist unknown_beside(const WheelTwist& twist, const Eigen::Vector3d& variance,
                                                 const NavState& before) {
    constexpr double kFar = 1000.0;
    constexpr double kLeast = 100.0;  // [m/s, rad/s]
    const double speed = std::hypot(twist.v_x, twist.v_y) + before.v_base.norm();
    const double rate = std::abs(twist.w_z) + before.w_base.norm();
    return {std::max({kLeast, kFar * std::sqrt(variance.head<2>().maxCoeff()), 10.0 * speed}),
            std::max({kLeast, kFar * std::sqrt(variance.z()), 10.0 * rate})};
  }

  static constexpr double kNoRotation = 1.0;     // [rad/√s]
  static constexpr double kScaleOfNoise = 0.2;   // share of the noise per rate that is a constant error
  static constexpr double kFirstInterval = 0.1;  // [s], before there is a previous sample
  static constexpr double kMinInterval = 1e-3;   // [s], two samples with one stamp
  static constexpr double kShortest = 0.1;       // [s], of the intervals of increments
  static constexpr double kSlow = 0.1;           // [m/s], of a robot that moves
  static constexpr double kSlowTurn = 0.1;       // [rad/s], the same
  static constexpr double kMinDensity = 1e-5;    // keeps R positive definite where noise vanishes with speed

  std::shared_ptr<const WheelModel> model_;
  Density speed_;
  Density lateral_;
  Density yaw_;
  std::optional<Density> vertical_;  // nothing: not observed
  double still_speed_;
  double still_rate_;
  double max_interval_;
  Systematic systematic_;
  std::optional<Time> last_stamp_;
};

}  // namespace

}  // namespace waymark::odometry

WAYMARK_PLUGIN(waymark::Sensor, waymark::odometry::Odometry, "odometry", "1.1.0")
