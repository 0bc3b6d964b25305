// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "attitude_filter.hpp"
#include "device_orientation.hpp"
#include "earth_field.hpp"
#include "imu_updates.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::imu {

namespace {

constexpr double kDegree = AttitudeSettings::kDegree;

/// In degrees in the YAML, in rad here.
void read_degrees(const Config& config, const Config::Key& key, double& value) {
  value = kDegree * config.positive(key, value / kDegree);
}

void read_gyro(const Config& config, AttitudeSettings& s) {
  s.gyro_noise =
      config.positive({"gyro_noise_rad_per_sqrt_s", "rad/√s", "angle random walk of the gyro"}, s.gyro_noise);
  s.gyro_noise_per_rate = config.non_negative(
      {"gyro_noise_per_rate_sqrt_s", "√s", "angle random walk per rad/s of rate: scale and axis errors"},
      s.gyro_noise_per_rate);
  s.bias_sigma =
      config.positive({"bias_sigma_radps", "rad/s", "σ of the gyro bias at the start, per axis"}, s.bias_sigma);
  s.bias_walk =
      config.non_negative({"bias_walk_radps_per_sqrt_s", "rad/s/√s", "random walk of the gyro bias"}, s.bias_walk);
  s.bias_limit = config.positive({"bias_limit_radps", "rad/s", "the gyro bias of no axis is larger"}, s.bias_limit);
}

void read_accelerometer(const Config& config, AttitudeSettings& s) {
  s.accelerometer_time_s = config.positive(
      {"accelerometer_time_s", "s", "low-pass of the specific force in the map frame"}, s.accelerometer_time_s);
  s.acceleration_time_s =
      config.non_negative({"acceleration_time_s", "s", "how long the errors of the specific force's direction stay"},
                          s.acceleration_time_s);
  read_degrees(config,
               {"tilt_sigma_deg", "°",
                "noise of the specific force's direction: σ² = sigma² + (per_motion·a/g)² + (per_magnitude·Δ/g)²"},
               s.tilt_sigma);
  s.tilt_per_motion = config.non_negative(
      {"tilt_per_motion",
       "per_motion in the noise of `tilt_sigma_deg`; a is the r.m.s. of what the low-pass takes out"},
      s.tilt_per_motion);
  s.tilt_per_magnitude = config.non_negative(
      {"tilt_per_magnitude",
       "per_magnitude in the noise of `tilt_sigma_deg`; Δ is the deviation of the low-passed magnitude from gravity"},
      s.tilt_per_magnitude);
}

/// `earth`: a declination that the YAML gives turns the filter's own map; the model's comes in behind it, where date
/// and place are known.
AttitudeSettings read_attitude_settings(const Config& config, const magnetic_model::EarthField& earth) {
  AttitudeSettings s;
  s.gravity_mps2 =
      config.positive({"gravity_mps2", "m/s²", "gravity as the accelerometer should show it"}, s.gravity_mps2);
  s.levelling_s =
      config.non_negative({"levelling_s", "s", "start-up average of specific force and field"}, s.levelling_s);
  s.max_gap_s =
      config.positive({"max_gap_s", "s", "a longer gap without rate: level again, keep the bias"}, s.max_gap_s);
  read_gyro(config, s);
  read_accelerometer(config, s);
  read_degrees(config, {"heading_sigma_deg", "°", "noise of the magnetic heading"}, s.heading_sigma);
  s.heading_time_s = config.non_negative({"heading_time_s", "s", "how long the errors of the magnetic heading stay"},
                                         s.heading_time_s);
  if (!earth.uses_model()) s.declination = earth.at(Time{}, nullptr).declination;
  s.field_strength_limit =
      config.positive({"field_strength_limit",
                       "a field whose strength strays farther from its reference, as a share of it, is refused"},
                      s.field_strength_limit);
  read_degrees(config, {"field_dip_limit_deg", "°", "a field whose dip strays farther from its reference is refused"},
               s.field_dip_limit);
  return s;
}

/// An inertial measurement unit as a cascade (docs/math/imu.md): its own filter makes attitude and bias-free rates
/// out of the axes; the main filter gets the rates with roll and pitch, or, if configured, the whole attitude with the
/// heading and then no rates of the same gyro. The device's own attitude can take the place of the cascade's.
class Imu final : public Sensor {
 public:
  Imu(const Config& config, const Rig& rig)
      : q_base_sensor_(rig.T_base_sensor(config.text("name")).q),
        earth_(config, 0.0),
        filter_(read_attitude_settings(config, std::as_const(earth_))),
        heading_(config.boolean(
            {"heading",
             "the whole attitude, with the magnetometer's heading, is given instead of the rates: not both out of one "
             "gyro; the sensor then ties the robot to the map's frame and is not a motion source any more"},
            false)),
        rates_(!heading_ ||
               config.boolean({"rates",
                               "with `heading`: the rates are given, too, and the sensor is a motion source again: for "
                               "a robot on which nothing else measures how it turns"},
                              false)),
        tilt_(config.boolean(
            {"tilt",
             "roll and pitch are given to the main filter (`motion.kind: spatial` only); false for a gyro alone"},
            true)),
        reports_standstill_(read_reports_standstill(config)),
        bias_time_(config.non_negative(
            {"bias_time_s", "s", "how long the error of the bias stays, for the noise of the rates"}, 10.0)),
        yaw_bias_sigma_(config.positive(
            {"yaw_bias_sigma_radps", "rad/s", "for `yaw_bias: state`: σ of the bias at the start"}, 5e-3)),
        yaw_bias_walk_(config.non_negative(
            {"yaw_bias_walk_radps_per_sqrt_s", "rad/s/√s", "for `yaw_bias: state`: random walk of the bias"}, 3e-5)),
        mounting_limit_(
            kDegree *
            config.number_in({"max_mounting_tilt_deg", "°",
                              "if up is farther than this from the base's z axis after levelling, every sample is "
                              "refused: `gravity points along +y of the sensor: check the mounting`"},
                             1.0, 180.0, 45.0)) {
    if (heading_ && !tilt_) config.fail("tilt", "heading needs roll and pitch, too");
    const std::string orientation =
        config.choice({"orientation",
                       "`own`: the attitude of the cascade; `device`: the ready-made attitude of the samples "
                       "(`q_enu_sensor`) takes the place of the cascade's roll, pitch and heading; rates, their bias "
                       "and rest stay the cascade's, and a sample may then lack the rate"},
                      {"own", "device"}, "own");
    if (orientation == "device") device_.emplace(config);
    const std::string yaw_bias = config.choice(
        {"yaw_bias",
         "`state`: the gyro's bias about the base's z axis is a state of the main filter, estimated from what else "
         "observes the heading, and at rest; `cascade`: left to the cascade, with `bias_time_s`"},
        {"state", "cascade"}, "state");
    yaw_bias_state_ = yaw_bias == "state" && !heading_;
    if (heading_) {
      own_magnetometer_ = config.boolean(
          {"own_magnetometer",
           "with `heading`: true if a compass of the same robot is another device; else `check` refuses both together"},
          false);
    }
  }

  /// What remains of the gyro's bias about the base's z axis: the cascade cannot see it while the robot moves, and it
  /// does not change from sample to sample as noise does.
  StateBlock block() const override {
    if (!yaw_bias_state_) return {};
    BlockState bias;
    bias.name = "yaw_bias_radps";
    bias.initial_sigma = yaw_bias_sigma_;
    bias.walk_per_sqrt_s = yaw_bias_walk_;
    return {bias};
  }
  SensorTraits traits() const override {
    SensorTraits traits{.is_motion_source = rates_, .is_absolute = heading_, .observes_roll_and_pitch = tilt_};
    if (heading_ && !own_magnetometer_) traits.instrument = magnetic_model::kMagnetometer;
    return traits;
  }

  /// From one sample, so only as good as the robot is at rest.
  std::optional<StartHint> start_hint(const Measurement& measurement, const Datum* datum) const override {
    if (!heading_) return std::nullopt;
    const auto& sample = measurement.as<ImuSample>();
    StartHint hint;
    if (device_) {
      const Eigen::Quaterniond q = from_true_north(device_->of(sample), device_declination(measurement.stamp, datum));
      hint.yaw_rad = so3::yaw(q * q_base_sensor_.conjugate());
      hint.yaw_sigma_rad = device_->heading_sigma();
      return hint;
    }
    AttitudeFilter alone(filter_.settings());
    alone.process(measurement.stamp, sample);
    if (!alone.knows_heading()) return std::nullopt;
    const Eigen::Quaterniond q = from_true_north(alone.q_map_sensor(), model_declination(measurement.stamp, datum));
    hint.yaw_rad = so3::yaw(q * q_base_sensor_.conjugate());
    hint.yaw_sigma_rad = filter_.settings().levelling_heading_sigma;
    return hint;
  }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum* datum) const override {
    const auto& sample = measurement.as<ImuSample>();
    ObservedMotion seen;
    seen.w_base = q_base_sensor_ * sample.w_sensor;
    seen.yaw_rate_radps = seen.w_base.z();
    seen.f_base = q_base_sensor_ * sample.f_sensor;
    seen.m_base = q_base_sensor_ * sample.m_sensor;
    seen.yaw_rate_bias_sigma_radps = filter_.settings().bias_sigma;
    if (heading_) {
      seen.yaw_rad = observed_yaw(measurement.stamp, sample, seen, datum);
      seen.yaw_error_sigma_rad = device_ ? device_->heading_sigma() : filter_.settings().heading_sigma;
    }
    return seen;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    const auto& sample = measurement.as<ImuSample>();
    const double interval = last_stamp_ ? to_seconds(measurement.stamp - *last_stamp_) : kFirstInterval;
    const std::uint64_t saturated = filter_.counts().saturated;
    const bool was_levelled = filter_.levelled();
    const bool is_first = !last_stamp_;
    const bool has_rate = !device_ || sample.w_sensor.allFinite();  // a device may deliver its attitude alone
    if (has_rate ? !filter_.process(measurement.stamp, sample) : interval <= 0.0) {
      throw DataError(device_ || sample.w_sensor.allFinite() ? "the sample is not later than the one before"
                                                             : "the angular rate is not finite");
    }
    last_stamp_ = measurement.stamp;
    if (filter_.levelled() && !was_levelled) check_mounting();
    if (fault_) throw DataError(*fault_);

    const double dt = std::clamp(interval, kMinInterval, filter_.settings().max_gap_s);
    const bool planar = prediction.planar();
    if (reports_standstill_ && has_rate) out.report_motion(!filter_.resting());
    if (rates_ && has_rate) add_rate(dt, planar, filter_.counts().saturated > saturated, out);
    if (heading_) {
      if (device_) {
        const double declination = device_declination(measurement.stamp, prediction.datum);
        add_attitude(from_true_north(device_->of(sample), declination), device_->variance(dt).asDiagonal(), planar,
                     out);
      } else if (filter_.levelled() && filter_.knows_heading()) {
        const double declination = model_declination(measurement.stamp, prediction.datum);
        add_attitude(from_true_north(filter_.q_map_sensor(), declination), own_covariance(dt, prediction), planar, out);
        if (filter_.disturbed())
          out.report_degraded("magnetic field disturbed: its strength or dip is not the usual one");
      } else if (is_first && filter_.knows_heading()) {
        // Else the robot would stand upright until the levelling is over.
        const double declination = model_declination(measurement.stamp, prediction.datum);
        add_attitude(from_true_north(filter_.q_map_sensor(), declination), levelling_covariance(), planar, out);
      }
      return;
    }
    if (has_rate && yaw_bias_state_ && filter_.resting() && !prediction.standing) add_yaw_bias(dt, prediction, out);
    if (!tilt_ || planar) return;
    if (device_) {
      add_tilt(device_->of(sample), device_->variance(dt).x(), out);
    } else if (filter_.levelled() && filter_.knows_tilt()) {
      const double variance = std::max(filter_.covariance()(0, 0), filter_.covariance()(1, 1));
      add_tilt(filter_.q_map_sensor(), variance * correlated(filter_.settings().accelerometer_time_s, dt), out);
    }
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Imu>(*this); }
  void save(OutArchive& out) const override { out(*this); }
  void load(InArchive& in) override { in(*this); }
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("imu", 1);
    std::string fault = fault_.value_or("");
    archive(filter_, last_stamp_, fault);
    if constexpr (Archive::kReads) fault_ = fault.empty() ? std::nullopt : std::optional(fault);
  }

 private:
  /// The heading that this sample shows by itself [rad]: the device's, or that of the field across gravity.
  double observed_yaw(Time stamp, const ImuSample& sample, const ObservedMotion& seen, const Datum* datum) const {
    if (device_) {
      const double declination = datum != nullptr ? device_declination(stamp, datum) : 0.0;
      return so3::yaw(from_true_north(device_->of(sample), declination) * q_base_sensor_.conjugate());
    }
    const Eigen::Vector3d east = seen.m_base.cross(seen.f_base);  // of the magnetic field, in the base frame
    const Eigen::Vector3d north = seen.f_base.cross(east);
    const bool is_model = earth_.uses_model();
    const double declination = !is_model          ? filter_.settings().declination
                               : datum != nullptr ? model_declination(stamp, datum)
                                                  : 0.0;
    return so3::wrap(std::atan2(north.normalized().x(), east.normalized().x()) - declination);
  }

  static constexpr double kFirstInterval = 0.01;  // [s], before there is a previous sample
  static constexpr double kMinInterval = 1e-4;    // [s]
  static constexpr double kCrawl = 0.05;          // [m/s], slower is not a drive
  static constexpr double kSlowTurn = 3e-3;       // [rad/s], that feels like rest
  static constexpr double kSlowTurnTime = 10.0;   // [s], how long one lasts

  static bool read_reports_standstill(const Config& config) {
    const Config::Key key{
        "reports_standstill",
        "rest counts as standing still where another motion sensor measures the speed and reports it, "
        "too; false: it never does"};
    const Config::Key old_key{"tells_standstill", "old name of `reports_standstill`"};
    return config.boolean(config.has(old_key) && !config.has(key) ? old_key : key, true);
  }

  static double correlated(double time, double dt) { return std::max(1.0, 2.0 * time / dt); }

  void check_mounting() {
    fault_.reset();
    if (filter_.knows_tilt()) fault_ = mounting_fault(filter_.levelling_force(), q_base_sensor_, mounting_limit_);
  }

  void add_rate(double dt, bool planar, bool saturated, UpdateList& out) const {
    const AttitudeSettings& s = filter_.settings();
    const Eigen::Vector3d& w = filter_.angular_rate();
    double density = s.gyro_noise + s.gyro_noise_per_rate * w.norm();
    if (saturated) density += s.saturation_noise;
    const Eigen::Matrix3d R_sensor = filter_.covariance().bottomRightCorner<3, 3>() * correlated(bias_time_, dt) +
                                     Eigen::Matrix3d(Eigen::Vector3d::Constant(density * density / dt).asDiagonal());
    const Eigen::Matrix3d R_base_sensor = q_base_sensor_.toRotationMatrix();
    Eigen::Vector3d w_base = R_base_sensor * w;
    Eigen::Matrix3d R_base = R_base_sensor * R_sensor * R_base_sensor.transpose();
    if (yaw_bias_state_) {  // the rate about z as it was measured: its bias is the main filter's
      w_base.z() += (R_base_sensor * filter_.gyro_bias()).z();
      R_base.row(2).setZero();
      R_base.col(2).setZero();
      R_base(2, 2) = density * density / dt;
    }
    out.emplace<RateUpdate>(w_base, R_base, planar, yaw_bias_state_ ? 1 : 0);
  }

  static bool is_known_to_drive(const Prediction& prediction) {
    const double speed = prediction.belief.mean.v_base.head<2>().norm();
    const double variance = std::max(0.0, prediction.velocity_variance().head<2>().maxCoeff());
    return speed > std::max(kCrawl, 3.0 * std::sqrt(variance));
  }

  /// At rest the cascade sees the bias that the main filter cannot see while it takes the robot for moving. But a
  /// smooth drive feels like rest, too. Straight on, the rate is not quite zero, and stays so for a while; in a wide
  /// curve it is not a bias at all, which shows by its size.
  void add_yaw_bias(double dt, const Prediction& prediction, UpdateList& out) const {
    const Eigen::Vector3d up = q_base_sensor_.conjugate() * Eigen::Vector3d::UnitZ();  // base z in the sensor's frame
    const double variance = up.dot(filter_.covariance().bottomRightCorner<3, 3>() * up);
    if (variance > yaw_bias_sigma_ * yaw_bias_sigma_) return;
    const double bias = up.dot(filter_.gyro_bias());
    const double change = std::abs(bias - prediction.block[0]);
    if (change > 3.0 * std::hypot(yaw_bias_sigma_, kSlowTurn) && is_known_to_drive(prediction)) return;
    out.emplace<YawBiasUpdate>(bias, (variance + kSlowTurn * kSlowTurn) * correlated(kSlowTurnTime, dt));
  }

  void add_tilt(const Eigen::Quaterniond& q_map_sensor, double variance, UpdateList& out) const {
    const Eigen::Vector3d up_base = q_base_sensor_ * (q_map_sensor.conjugate() * Eigen::Vector3d::UnitZ());
    out.emplace<TiltUpdate>(up_base, variance);
  }

  void add_attitude(const Eigen::Quaterniond& q_map_sensor, const Eigen::Matrix3d& R, bool planar,
                    UpdateList& out) const {
    const Eigen::Quaterniond q_map_base = q_map_sensor * q_base_sensor_.conjugate();
    if (planar) {
      out.emplace<HeadingUpdate>(so3::yaw(q_map_base), R(2, 2));
    } else {
      out.emplace<AttitudeUpdate>(q_map_base, R);
    }
  }

  /// Of the cascade's attitude, whose errors stay for a while. If the rates are given, too, and the main filter is
  /// still much less certain (at the start, after a saturated gyro), one reading counts in full, as in the cascade.
  Eigen::Matrix3d own_covariance(double dt, const Prediction& prediction) const {
    constexpr double kMuch = 9.0;  // 3σ
    const Eigen::Matrix3d P = filter_.covariance().topLeftCorner<3, 3>();
    const auto scale_of = [&](int axis, double time) {
      const int state = prediction.layout.active(3 + axis);
      const bool counts_in_full = rates_ && state >= 0 && prediction.belief.P(state, state) > kMuch * P(axis, axis);
      return counts_in_full ? 1.0 : std::sqrt(correlated(time, dt));
    };
    const AttitudeSettings& s = filter_.settings();
    const Eigen::Vector3d scale(scale_of(0, s.accelerometer_time_s), scale_of(1, s.accelerometer_time_s),
                                scale_of(2, s.heading_time_s));
    return scale.asDiagonal() * P * scale.asDiagonal();
  }

  /// Of what one sample says before the levelling is over.
  Eigen::Matrix3d levelling_covariance() const {
    const AttitudeSettings& s = filter_.settings();
    const Eigen::Vector3d sigma(s.levelling_tilt_sigma, s.levelling_tilt_sigma, s.levelling_heading_sigma);
    return sigma.cwiseAbs2().asDiagonal();
  }

  /// What the cascade does not know: it has a given declination in it already.
  double model_declination(Time stamp, const Datum* datum) {
    return earth_.uses_model() ? earth_.at(stamp, datum).declination : 0.0;
  }
  double model_declination(Time stamp, const Datum* datum) const {
    return earth_.uses_model() ? earth_.at(stamp, datum).declination : 0.0;
  }
  double device_declination(Time stamp, const Datum* datum) { return earth_.at(stamp, datum).declination; }
  double device_declination(Time stamp, const Datum* datum) const { return earth_.at(stamp, datum).declination; }
  static Eigen::Quaterniond from_true_north(const Eigen::Quaterniond& q_magnetic_sensor, double declination) {
    return declination == 0.0 ? q_magnetic_sensor : so3::exp({0.0, 0.0, -declination}) * q_magnetic_sensor;
  }

  Eigen::Quaterniond q_base_sensor_;
  magnetic_model::EarthField earth_;
  AttitudeFilter filter_;
  bool heading_;
  bool rates_;
  bool tilt_;
  bool reports_standstill_;
  double bias_time_;
  double yaw_bias_sigma_;
  double yaw_bias_walk_;
  double mounting_limit_;
  bool own_magnetometer_ = false;
  bool yaw_bias_state_ = false;
  std::optional<DeviceOrientation> device_;  // instead of the cascade's attitude
  std::optional<Time> last_stamp_;
  std::optional<std::string> fault_;
};

}  // namespace

}  // namespace waymark::imu

WAYMARK_PLUGIN(waymark::Sensor, waymark::imu::Imu, "imu", "1.1.0")
