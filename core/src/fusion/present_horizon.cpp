// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimation/ekf.hpp"
#include "estimation/new_start.hpp"
#include "fusion/horizons.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::fusion {

namespace {

/// Rejected fixes after which their own way is compared with the predicted one.
constexpr int kFewRejections = 4;
constexpr std::string_view kMotionWasWrong = "the motion source was wrong, or the heading";

/// 6σ of a position: what follows the measurements before it is no outlier, so it corrects the belief up to there.
const particles::Gates& wide_gates() {
  static const particles::Gates gates(1.0 - std::exp(-0.5 * 36.0));
  return gates;
}

/// Of the length of an innovation.
std::string_view unit_of(const Update& update) {
  switch (update.observes()) {
    case Quantity::position:
    case Quantity::height:
      return " m";
    case Quantity::attitude:
      return " rad";
    case Quantity::velocity:
      return " m/s";
    case Quantity::other:
      break;
  }
  return " (of mixed units)";
}

/// Whether a position that was fused in a wide gate shows that the prediction was wrong: by itself, or by being the
/// second one in short time beyond the usual gate, which one in a thousand is by chance.
bool is_beyond_chance(SensorRecord& record, const particles::MixtureOutcome& outcome) {
  static const particles::Gates certain(1.0 - 1e-6);
  constexpr int kShort = 10;  // positions
  const auto rows = static_cast<int>(outcome.innovation.size());
  int& since = record.state.since_surprise;
  const bool is_again = since < kShort;
  if (outcome.nis > record.policy.gates[rows]) {
    since = 0;
    return is_again || outcome.nis > certain[rows];
  }
  since = std::min(since + 1, SensorState::kMostCounted);
  return false;
}

}  // namespace

bool PresentHorizon::follow_motion(const Measurement& m, const UpdateList& updates) {
  if (update_standstill(m, updates)) return true;
  if (const auto& unknown = updates.twist_reset(); unknown && !standing()) {
    filter().release(unknown->velocity_sigma, unknown->rate_sigma);
  }
  return false;
}

/// A sensor's own states (a gyro's bias) are best observable at standstill, so a sensor with own states is updated
/// then, too.
bool PresentHorizon::update_standstill(const Measurement& m, const UpdateList& updates) {
  if (updates.motion() == UpdateList::Motion::not_reported) return false;
  monitoring::Standstill& standstill = steps().committed().standstill;
  const bool was_standing = standstill.standing();
  const bool is_whole_twist = updates.twist_reset().has_value();
  standstill.report(m.sensor, m.stamp,
                    {.moving = updates.motion() == UpdateList::Motion::moving,
                     .measures_velocity = is_whole_twist || record(m).state.measures_velocity,
                     .until_next = is_whole_twist});
  if (!was_standing && standstill.standing()) filter().stop();
  if (was_standing && !standstill.standing())
    filter().release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  const auto owner = static_cast<std::size_t>(record(m).policy.owner);
  return standstill.standing() && record(m).traits.is_motion_source && filter().layout().owners()[owner].block.empty();
}

void PresentHorizon::update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) {
  SensorRecord& record = this->record(m);
  const bool has_way = index == 0 && record.traits.is_absolute && update.observes() == Quantity::position;
  const Eigen::Vector2d p = has_way ? position() : Eigen::Vector2d::Zero();
  const bool follows = index == 0 && result.is_continuous && update.observes() == Quantity::position &&
                       record.slot.max_consecutive_rejections > 0 && !steps().maps().localizes();
  particles::UpdatePolicy policy = record.policy;
  if (follows && policy.gates[2] < wide_gates()[2]) policy.gates = wide_gates();
  const particles::MixtureOutcome outcome = filter().update(update, policy);
  if (!steps().account(m, index, outcome, result) || record.policy.evaluate_only) return;
  result.observes_position = result.observes_position || update.observes() == Quantity::position;
  const bool is_position = index == 0 && update.observes() == Quantity::position && outcome.innovation.size() > 1;
  // Maps know the heading.
  const bool compares_ways = has_way && is_position && steps().maps().empty();
  const double off = compares_ways ? heading_off(m, update, p, outcome) : 0.0;
  if (outcome.accepted) {
    if (is_position) check_for_bias(m, outcome, result);
    if (follows && is_beyond_chance(record, outcome)) result.degraded_reason = kMotionWasWrong;
  } else if (record.slot.max_consecutive_rejections > 0) {
    const int rejections = ++record.state.rejections_in_a_row[index];
    const bool is_certain = follows && is_position;
    if (off != 0.0 && (is_certain || rejections >= kFewRejections)) {
      turn(m, update, outcome, off);
    } else if (is_certain) {
      result.degraded_reason = kMotionWasWrong;
      reacquire(m, index, update, outcome,
                fmt::format("a measurement does not fit the prediction, but follows the ones before it: the motion was "
                            "wrong by {:.3g}{}",
                            outcome.innovation.norm(), unit_of(update)));
    } else if (rejections >= record.slot.max_consecutive_rejections) {
      steps().committed().health.reacquired(m.stamp);
      reacquire(m, index, update, outcome,
                fmt::format("{} measurements in a row rejected, the last one by {:.3g}{}", rejections,
                            outcome.innovation.norm(), unit_of(update)));
    }
  }
  if (auto& way = record.state.way; has_way && way) way->p = position();
}

Eigen::Vector2d PresentHorizon::position() { return belief().mean.T_map_base.p.head<2>(); }

/// Angle between the way that the fixes went since the last accepted one and the way that was predicted between them,
/// if both are as long as each other: then the fixes are right, and the heading is wrong, as after a slip of one wheel.
/// 0 while the noise of the fixes does not determine it. `p`: the position before the update.
double PresentHorizon::heading_off(const Measurement& m, const Update& update, const Eigen::Vector2d& p,
                                   const particles::MixtureOutcome& outcome) {
  constexpr double kSquaredSigmas = 25.0;  // of the way, so that its direction is within 0.2 rad
  constexpr double kSameLength = 0.3;
  constexpr double kLeast = 0.3;  // [rad]: less is corrected by the update
  auto& way = record(m).state.way;
  const Eigen::Vector2d z = p + outcome.innovation.head<2>();
  const auto begin = [&] { way = {.z = z, .p = p, .predicted = Eigen::Vector2d::Zero(), .open = !outcome.accepted}; };
  if (!way || (outcome.accepted && !way->open)) {
    begin();
    return 0.0;
  }
  way->open = true;
  way->predicted += p - way->p;
  Linearization model;
  const int block = filter().layout().block_offset(static_cast<int>(m.sensor));
  update.linearize({belief().mean, belief().mean.block.data() + block}, model);
  const double variance = 2.0 * model.R.diagonal().head<2>().maxCoeff();
  const Eigen::Vector2d predicted = way->predicted;
  const Eigen::Vector2d fixed = z - way->z;
  const double length = predicted.norm();
  if (length * length < kSquaredSigmas * variance) return 0.0;
  const double angle = std::atan2(predicted.x() * fixed.y() - predicted.y() * fixed.x(), predicted.dot(fixed));
  const bool is_off = std::abs(fixed.norm() - length) < kSameLength * length && std::abs(angle) > kLeast;
  if (is_off && outcome.accepted)
    return 0.0;  // perhaps the updates find the heading; else the next rejected one shows it
  begin();
  return is_off ? angle : 0.0;
}

/// Biased innovations of a position: the wheels slip, or the fixes drift. The two cannot be distinguished here; in both
/// cases the position's covariance is too small. Where maps localise, the pose in the map stays correct: only the
/// georeference is inflated, and without one nothing, since drifting fixes would distort the map.
void PresentHorizon::check_for_bias(const Measurement& m, const particles::MixtureOutcome& outcome,
                                    UpdateResult& result) {
  SensorState& state = record(m).state;
  if (!state.bias.add(outcome.innovation, outcome.S)) return;
  const Eigen::Vector2d bias = state.bias.mean().head<2>();
  const bool inflates = filter().georeference() || !steps().maps().localizes();
  if (inflates) filter().inflate_pose({.position = bias.squaredNorm()});
  if (settings_.smooth) steps().committed().smoother.cut_next();
  result.degraded_reason = "its innovations are biased: it, or the motion source, is wrong";
  if (state.biased++ == 0) {
    steps().committed().note(
        m.stamp,
        fmt::format("{}: its innovations are biased by {:.3g} m; it, or the motion source, is wrong{} "
                    "(further times are only counted)",
                    record(m).slot.name, bias.norm(), inflates ? ", and the position's covariance was inflated" : ""));
  }
  state.bias.reset();
}

/// The heading was wrong by `off`: pose and twist begin anew with the one of the fixes' way. A linear filter would not
/// find a heading that is wrong by a right angle or more.
void PresentHorizon::turn(const Measurement& m, const Update& update, const particles::MixtureOutcome& outcome,
                          double off) {
  // The slip may go on, or have begun in the middle of the way: the heading is off by more than the way then.
  const double yaw_sigma = std::max(0.35, std::abs(off) / 3.0);  // 20°
  const StateLayout& layout = filter().layout();
  estimation::NewStart start{belief(), false};
  ErrorMatrix& P = start.prior.P;
  Pose& pose = start.prior.mean.T_map_base;
  pose.p.head<2>() += outcome.innovation.head<2>();
  pose.q = (so3::exp({0.0, 0.0, off}) * pose.q).normalized();
  P.setZero();
  estimation::ekf::release(start.prior, layout, settings_.start.velocity_sigma, settings_.start.rate_sigma);
  const auto& index = layout.pose_indices();
  // An antenna off the axle was elsewhere with the other heading.
  P(index[0], index[0]) = P(index[1], index[1]) = 1.0 + outcome.S.topLeftCorner<2, 2>().trace();
  P(index[2], index[2]) = yaw_sigma * yaw_sigma;
  filter().begin_anew(start);
  if (settings_.smooth) steps().committed().smoother.cut_next();
  SensorRecord& record = this->record(m);
  steps().committed().health.reacquired(m.stamp);
  particles::UpdatePolicy without_gate = record.policy;
  without_gate.ignore_gate = true;
  filter().update(update, without_gate);
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  steps().committed().note(
      m.stamp,
      fmt::format("{}: rejected measurements, whose own way is turned by {:.0f}° against the predicted one: the "
                  "heading was set to theirs",
                  record.slot.name, off * kDegrees));
  record.state.rejections_in_a_row[0] = 0;
}

/// Inflates what an update observes, so that its last miss is plausible. Where the sensor is absolute, also the yaw.
void PresentHorizon::inflate(const Update& update, bool is_absolute, const particles::MixtureOutcome& outcome) {
  constexpr double kYawSigma = 0.17;  // 10°: enough for the next fixes to correct the heading
  const double miss = outcome.innovation.norm();
  estimation::ekf::PoseVariance variance;
  variance.yaw = is_absolute ? kYawSigma * kYawSigma : 0.0;
  bool is_of_twist = false;
  switch (update.observes()) {
    case Quantity::position:
      variance.position = variance.height = miss * miss;
      break;
    case Quantity::height:
      variance = {.height = miss * miss};
      break;
    case Quantity::attitude:
      variance.tilt = miss * miss;
      if (is_absolute) variance.yaw = std::max(variance.yaw, miss * miss);
      break;
    case Quantity::velocity:
      is_of_twist = true;
      break;
    case Quantity::other:
      is_of_twist = !is_absolute;
      if (is_absolute) {  // the unit of the miss is unknown; its ratio to what was expected, the NIS, has none
        const Eigen::Matrix3d P = pose_covariance(filter().mixture(), filter().layout());
        variance.position = outcome.nis * std::max(P(0, 0), P(1, 1));
      }
      break;
  }
  filter().inflate_pose(variance);
  if (is_of_twist) filter().release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
}

/// After too many rejections in a row, or one that the sensor states to be right, the filter is assumed to be wrong: to
/// reject a correct sensor for ever is the worse error.
void PresentHorizon::reacquire(const Measurement& m, std::size_t index, const Update& update,
                               const particles::MixtureOutcome& outcome, const std::string& why) {
  SensorRecord& record = this->record(m);
  inflate(update, record.traits.is_absolute, outcome);
  if (settings_.smooth) steps().committed().smoother.cut_next();
  particles::UpdatePolicy without_gate = record.policy;
  without_gate.ignore_gate = true;
  filter().update(update, without_gate);
  steps().committed().note(
      m.stamp, fmt::format("{}: {}; the covariance was inflated and the sensor re-acquired", record.slot.name, why));
  record.state.rejections_in_a_row[index] = 0;
}

void PresentHorizon::map(const Measurement& m, const Extraction& extraction, UpdateResult& result) {
  steps().map(m, filter().now(), extraction, result);
  if (!std::ranges::any_of(extraction.inputs, &particles::MappingInput::localize)) return;
  result.localized = filter().localized();
  result.match_failed = filter().match_failed();
  result.match_searched = filter().match_searched();
  result.suspected_tears = filter().suspected_tears();
}

}  // namespace waymark::fusion
