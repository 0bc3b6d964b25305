// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "direction_update.hpp"
#include "earth_field.hpp"
#include "field_monitor.hpp"
#include "heading_monitor.hpp"
#include "magnetometer.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/sensor.hpp"

namespace waymark::compass {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// What one measurement gives: a direction of the base whose heading in the map is known.
struct Direction {
  Eigen::Vector3d u_base;
  double heading = 0.0;  ///< counter-clockwise from east [rad]
  double sigma = 0.0;    ///< [rad]
  bool is_field = false;
};

/// A compass that delivers a heading, or the field in its own axes (docs/math/compass.md).
class Compass final : public Sensor {
 public:
  Compass(const Config& config, const Rig& rig)
      : q_base_sensor_(rig.T_base_sensor(config.text("name")).q),
        magnetometer_(config),
        earth_(config),
        sigma_(kDegree *
               config.number_in({"sigma_deg", "°", "noise of the heading; the floor, whatever the device claims"}, 1e-3,
                                180.0, 5.0)),
        use_reported_(config.boolean({"use_reported_sigma", "use the device's own σ where it is larger"}, true)),
        offset_sigma_(kDegree * config.non_negative(
                                    {"offset_sigma_deg", "°",
                                     "slowly varying error as a state of its own (first-order Gauss–Markov); 0: none"},
                                    0.0)),
        offset_tau_(config.positive({"offset_tau_s", "s", "time constant of the slowly varying error"}, 60.0)),
        noise_time_(config.non_negative(
            {"noise_time_s", "s",
             "how long the errors of the heading stay: R is multiplied by max(1, 2 · this / interval)",
             "1 without `offset_sigma_deg`, else 0"},
            offset_sigma_ > 0.0 ? 0.0 : 1.0)),
        own_magnetometer_(config.boolean(
            {"own_magnetometer",
             "true: another device than the one whose heading an `imu` gives; else `check` refuses both together"},
            false)),
        field_(config),
        jumps_(config) {}

  StateBlock block() const override {
    if (offset_sigma_ == 0.0) return {};
    BlockState offset;
    offset.name = "offset_rad";
    offset.initial_sigma = offset_sigma_;
    offset.stationary_sigma = offset_sigma_;
    offset.tau_s = offset_tau_;
    return {offset};
  }
  SensorTraits traits() const override {
    SensorTraits traits{.is_absolute = true};
    if (!own_magnetometer_ && !earth_.from_true_north()) traits.instrument = magnetic_model::kMagnetometer;
    return traits;
  }

  /// Level, or as the specific force has it if there is one: as good as the robot is at rest.
  std::optional<StartHint> start_hint(const Measurement& measurement, const Datum* datum) const override {
    const Direction seen =
        direction(measurement,
                  counts_from_true_north(measurement) ? magnetic_model::Field{} : earth_.at(measurement.stamp, datum));
    const Eigen::Quaterniond q_level_base = levelled(measurement);
    const double u = heading_of(q_level_base * seen.u_base);
    const double forward = heading_of(q_level_base * Eigen::Vector3d::UnitX());
    StartHint hint;
    hint.yaw_rad = so3::wrap(seen.heading - u + forward);
    hint.yaw_sigma_rad = std::hypot(seen.sigma, offset_sigma_);
    return hint;
  }

  std::optional<ObservedMotion> observed_motion(const Measurement& measurement, const Datum* datum) const override {
    ObservedMotion seen;
    // A field without place or date still turns as the robot does.
    const bool is_placed = counts_from_true_north(measurement) || !earth_.uses_model() || datum != nullptr;
    const Direction direction_seen =
        direction(measurement, counts_from_true_north(measurement) || !is_placed ? magnetic_model::Field{}
                                                                                 : earth_.at(measurement.stamp, datum));
    const Eigen::Quaterniond q_level_base = levelled(measurement);
    seen.yaw_rad = so3::wrap(direction_seen.heading - heading_of(q_level_base * direction_seen.u_base) +
                             heading_of(q_level_base * Eigen::Vector3d::UnitX()));
    seen.yaw_error_sigma_rad = std::hypot(direction_seen.sigma, offset_sigma_);
    if (direction_seen.is_field) seen.m_base = direction_seen.u_base;
    return seen;
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    const magnetic_model::Field earth =
        counts_from_true_north(measurement) ? magnetic_model::Field{} : earth_.at(measurement.stamp, prediction.datum);
    const Direction seen = direction(measurement, earth);
    const double dt = last_stamp_ ? std::max(0.0, to_seconds(measurement.stamp - *last_stamp_)) : 0.0;
    last_stamp_ = std::max(last_stamp_.value_or(measurement.stamp), measurement.stamp);

    const NavState& mean = prediction.belief.mean;
    if (seen.is_field) {
      const double turn = mean.w_base.z() * dt;
      if (!field_.judge(mean.T_map_base.q * seen.u_base, earth, dt, turn)) {
        out.report_degraded("magnetic field disturbed: its strength or dip is not the Earth's");
        return;
      }
    }
    // Readings close together repeat each other's error.
    const double repeated = last_used_ ? 2.0 * noise_time_ / std::max(kMinInterval, dt) : 1.0;
    const double variance = seen.sigma * seen.sigma * std::max(1.0, repeated);
    if (!is_plausible(measurement.stamp, seen, prediction)) {
      out.report_degraded("heading jumps against the predicted turn");
      return;
    }
    last_used_ = true;
    out.emplace<DirectionUpdate>(seen.u_base, seen.heading, variance, offset_sigma_ > 0.0 ? 1 : 0);
  }

  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Compass>(*this); }
  void save(OutArchive& out) const override { out(*this); }
  void load(InArchive& in) override { in(*this); }
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("compass", 1);
    archive(last_stamp_, last_used_, field_, jumps_);
  }

 private:
  static constexpr double kMinInterval = 1e-4;  // [s]

  /// Neither date nor place are needed then.
  bool counts_from_true_north(const Measurement& measurement) const {
    if (earth_.from_true_north()) return true;
    return measurement.payload->type() == CompassHeading::kType && measurement.as<CompassHeading>().from_true_north;
  }

  Direction direction(const Measurement& measurement, const magnetic_model::Field& earth) const {
    constexpr double kNorth = 0.5 * std::numbers::pi;
    Direction seen;
    seen.sigma = sigma_;
    const std::string_view type = measurement.payload->type();
    if (type == CompassHeading::kType) {
      const auto& compass = measurement.as<CompassHeading>();
      if (!std::isfinite(compass.heading_rad)) throw DataError("the heading is not finite");
      seen.u_base = q_base_sensor_ * Eigen::Vector3d::UnitX();
      seen.heading = so3::wrap(kNorth - compass.heading_rad - earth.declination);
      if (use_reported_ && std::isfinite(compass.sigma_rad)) seen.sigma = std::max(sigma_, compass.sigma_rad);
      return seen;
    }
    const Eigen::Vector3d& m =
        type == ImuSample::kType ? measurement.as<ImuSample>().m_sensor : measurement.as<MagneticField>().m_sensor;
    seen.u_base = q_base_sensor_ * magnetometer_.calibrated(m);
    seen.heading = so3::wrap(kNorth - earth.declination);
    seen.is_field = true;
    return seen;
  }

  Eigen::Quaterniond levelled(const Measurement& measurement) const {
    if (measurement.payload->type() != ImuSample::kType) return Eigen::Quaterniond::Identity();
    const Eigen::Vector3d& f = measurement.as<ImuSample>().f_sensor;
    if (!f.allFinite() || f.norm() == 0.0) return Eigen::Quaterniond::Identity();
    return Eigen::Quaterniond::FromTwoVectors(q_base_sensor_ * f, Eigen::Vector3d::UnitZ());
  }

  /// Against the mixture; the offset counts with its whole stationary uncertainty.
  bool is_plausible(Time stamp, const Direction& seen, const Prediction& prediction) {
    const double variance = seen.sigma * seen.sigma + offset_sigma_ * offset_sigma_;
    const DirectionUpdate model(seen.u_base, seen.heading, variance, 0);
    const PredictedInnovation innovation = prediction.innovation(model);
    const double offset = offset_sigma_ > 0.0 ? prediction.block[0] : 0.0;
    return jumps_.judge(stamp, so3::wrap(innovation.nu(0) - offset), innovation.S(0, 0));
  }

  Eigen::Quaterniond q_base_sensor_;
  Magnetometer magnetometer_;
  magnetic_model::EarthField earth_;
  double sigma_;
  bool use_reported_;
  double offset_sigma_;
  double offset_tau_;
  double noise_time_;
  bool own_magnetometer_;

  FieldMonitor field_;
  HeadingMonitor jumps_;
  std::optional<Time> last_stamp_;
  bool last_used_ = false;  // some reading has been given to the filter
};

}  // namespace

}  // namespace waymark::compass

WAYMARK_PLUGIN(waymark::Sensor, waymark::compass::Compass, "compass", "1.0.0")
