// SPDX-License-Identifier: Apache-2.0
#include "fusion/start_finder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimation/ekf.hpp"

namespace waymark::fusion {
namespace {

/// σ of roll and pitch at the start [rad]: the robot may stand on a slope.
constexpr double kTiltSigma = 0.17;

}  // namespace

namespace {

/// A heading less certain than this is not one: beyond it the linearised filter would not find the rest [rad].
constexpr double kLargestYawSigma = 0.2;
/// The fixes that gave the heading are fused afterwards, too. A prior with this factor on its σ repeats a quarter of
/// their information.
constexpr double kRepeated = 2.0;

constexpr double kDegree = std::numbers::pi / 180.0;

Eigen::Vector2d chord(const StartHint& to, const StartHint& from) {
  return (*to.p_map_point - *from.p_map_point).head<2>();
}

}  // namespace

std::optional<Start> StartFinder::process(const Measurement& measurement, const std::optional<StartHint>& hint,
                                          const std::vector<SensorRecord>& sensors,
                                          const std::vector<Measurement>& before) {
  if (!sources_.has_absolute || (settings_.position && settings_.yaw)) return make_start(measurement.stamp, nullptr);
  if (reckoning_) reckoning_->process(measurement);
  if (!hint) return std::nullopt;

  if (hint->yaw_rad) {
    yaw_ = hint->yaw_rad;
    yaw_sigma_ = hint->yaw_sigma_rad;
  }
  if (hint->p_map_point) add_fix(measurement, *hint, sensors, before);
  const bool have_yaw = settings_.yaw || yaw_;
  const Fix* fix = first_fix();
  if (!have_yaw || (!settings_.position && fix == nullptr)) return std::nullopt;
  return make_start(fix != nullptr ? fix->stamp : measurement.stamp, fix);
}

void StartFinder::restart(const StartSettings& settings, StartSources sources) {
  settings_ = settings;
  sources_ = sources;
  first_fixes_.clear();
  reckoning_.reset();
  yaw_.reset();
  yaw_sigma_ = 0.0;
  path_sigma_.reset();
}

void StartFinder::add_fix(const Measurement& measurement, const StartHint& hint,
                          const std::vector<SensorRecord>& sensors, const std::vector<Measurement>& before) {
  const bool wants_heading = !settings_.yaw && !yaw_;
  if (wants_heading && !reckoning_) {
    reckoning_.emplace(process_model_, settings_, standstill_after_, sensors, measurement.stamp);
    for (const Measurement& m : before) {
      if (m.stamp > measurement.stamp) reckoning_->process(m);
    }
  }
  if (wants_heading) reckoning_->add_fix(measurement, hint);
  const auto first = std::ranges::find(first_fixes_, measurement.sensor, &Fix::sensor);
  const bool is_first = first == first_fixes_.end();
  if (!is_first) first->farthest = std::max(first->farthest, chord(hint, first->hint).norm());
  if (wants_heading && reckoning_->measures_speed()) {
    find_heading_on_path();
  } else if (wants_heading && !is_first && measurement.stamp > first->stamp) {
    find_heading_on_chord(hint, *first);
  }
  if (is_first) first_fixes_.push_back({measurement.sensor, measurement.stamp, measurement.sequence, hint});
}

/// The motion sensors give the path, so that curves, driving in reverse and turning in place are no error.
void StartFinder::find_heading_on_path() {
  const auto fit = reckoning_->heading(settings_.min_course_distance);
  path_sigma_ = fit ? std::optional(fit->sigma) : std::nullopt;
  if (!fit || fit->sigma > kLargestYawSigma) return;
  yaw_ = fit->yaw;
  yaw_sigma_ = std::max(settings_.yaw_sigma, kRepeated * fit->sigma);
  reckoning_.reset();
}

/// Fixes less far apart give no course; `sigma` is of their difference.
double StartFinder::least_chord(double sigma) const { return std::max(5.0 * sigma, settings_.min_course_distance); }

/// From two fixes of one antenna, where no sensor measures the speed.
void StartFinder::find_heading_on_chord(const StartHint& hint, const Fix& first) {
  const Eigen::Vector2d course = chord(hint, first.hint);
  const double sigma = std::hypot(hint.sigma_m, first.hint.sigma_m);
  if (course.norm() > least_chord(sigma)) {
    // Assumes that the robot starts to drive forwards.
    yaw_ = std::atan2(course.y(), course.x());
    yaw_sigma_ = std::max(settings_.yaw_sigma, sigma / course.norm());
  }
}

Start StartFinder::make_start(Time stamp, const Fix* fix) const {
  Start start;
  const double yaw = settings_.yaw ? *settings_.yaw : yaw_.value_or(0.0);
  const double yaw_sigma = yaw_ && !settings_.yaw ? yaw_sigma_ : settings_.yaw_sigma;
  Eigen::Vector2d position = settings_.position.value_or(Eigen::Vector2d::Zero());
  double position_sigma = settings_.position_sigma;
  Eigen::Vector2d position_by_yaw = Eigen::Vector2d::Zero();  // ∂position/∂yaw
  if (!settings_.position && fix != nullptr) {
    const Eigen::Vector2d arm = (so3::from_rpy(0.0, 0.0, yaw) * fix->hint.p_base_point).head<2>();
    position = fix->hint.p_map_point->head<2>() - arm;
    position_by_yaw = {arm.y(), -arm.x()};
    position_sigma = std::max(position_sigma, fix->hint.sigma_m);
    start.used = true;
    start.used_sensor = fix->sensor;
    start.used_sequence = fix->sequence;
  }
  start.prior.stamp = stamp;
  start.prior.mean.T_map_base = Pose::planar(position.x(), position.y(), yaw);
  start.prior.mean.T_map_base.p.z() = settings_.height;
  start.prior.mean.block.setZero(layout_.block_size());
  start.prior.P.setZero(layout_.size(), layout_.size());
  for (int i = 0; i < layout_.block_size(); ++i) {
    const BlockState& state = layout_.block_state(i);
    const int k = layout_.core_size() + i;
    start.prior.mean.block[i] = state.initial;
    start.prior.P(k, k) = state.initial_sigma * state.initial_sigma;
  }
  estimation::ekf::release(start.prior, layout_, settings_.velocity_sigma, settings_.rate_sigma);
  // Gravity, not the choice of the map, defines roll and pitch: with no variance they would stay upright for long.
  for (const int axis : {3, 4}) {
    const int k = layout_.active(axis);
    if (k >= 0) start.prior.P(k, k) = kTiltSigma * kTiltSigma;
  }

  // Without a fused absolute sensor the start pose is the map's gauge and has zero covariance. In a prior map it has
  // the given covariance, and stays a Gaussian until the first match: each particle then searches all of it.
  const double yaw_variance = yaw_sigma * yaw_sigma;
  Eigen::Matrix3d P;
  P.topLeftCorner<2, 2>() = position_sigma * position_sigma * Eigen::Matrix2d::Identity() +
                            yaw_variance * position_by_yaw * position_by_yaw.transpose();
  P.topRightCorner<2, 1>() = yaw_variance * position_by_yaw;
  P.bottomLeftCorner<1, 2>() = P.topRightCorner<2, 1>().transpose();
  P(2, 2) = yaw_variance;
  if (sources_.fuses_absolute || sources_.has_prior_map) {
    start.draw = !sources_.has_prior_map;
    estimation::ekf::add_pose_covariance(start.prior, layout_, P);
  } else if (sources_.has_absolute) {
    start.frame = P;
  }
  return start;
}

std::string StartFinder::missing() const {
  if (!settings_.position && first_fixes_.empty())
    return "no sensor gave a plausible position (set initial.x_m and initial.y_m, or check the position sensor)";
  return "the heading is unknown: " + missing_heading();
}

/// With the numbers by which the user sees the cause: too short a way, fixes that are too coarse, or a wrong unit.
std::string StartFinder::missing_heading() const {
  const auto widest = std::ranges::max_element(first_fixes_, {}, &Fix::farthest);
  if (widest == first_fixes_.end()) return "no sensor gave one (set initial.yaw_deg)";
  const std::string apart = fmt::format("the fixes lie up to {:.1f} m apart", widest->farthest);
  if (!reckoning_ || !reckoning_->measures_speed()) {
    return fmt::format(
        "no sensor has measured the speed, and {}; {:.1f} m are needed (set initial.yaw_deg, or drive on)", apart,
        least_chord(std::numbers::sqrt2 * widest->hint.sigma_m));
  }
  const std::string ways = fmt::format("{}, and the way by the motion sensors is {:.1f} m", apart, reckoning_->way());
  if (!path_sigma_) return ways + " (set initial.yaw_deg, or drive on; if these do not fit, a unit is wrong)";
  return fmt::format(
      "fixes and motion sensors give it to ± {:.2g}° only, {:.3g}° is needed; {} "
      "(if these do not fit, a unit is wrong: waymark doctor; otherwise set initial.yaw_deg, or drive on)",
      *path_sigma_ / kDegree, kLargestYawSigma / kDegree, ways);
}

}  // namespace waymark::fusion
