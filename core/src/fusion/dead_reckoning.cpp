// SPDX-License-Identifier: Apache-2.0
#include "fusion/dead_reckoning.hpp"

#include <algorithm>
#include <exception>

#include "estimation/ekf.hpp"
#include "fusion/setup.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::fusion {

namespace ekf = estimation::ekf;

namespace {

/// More points cost more than they improve the heading.
constexpr std::size_t kMostPoints = 32;

bool measures_motion(const SensorRecord& record) {
  return record.slot.enabled && record.state.sensor && !record.traits.is_absolute && is_fused_after_start(record.slot);
}

}  // namespace

DeadReckoning::DeadReckoning(const estimation::ProcessModel& process, const StartSettings& settings,
                             Duration standstill_after, const std::vector<SensorRecord>& sensors, Time begin)
    : process_(process), settings_(settings), standstill_(sensors.size(), standstill_after) {
  const StateLayout& layout = process.layout();
  belief_.stamp = begin;
  belief_.mean.block.setZero(layout.block_size());
  belief_.P.setZero(layout.size(), layout.size());
  for (int i = 0; i < layout.block_size(); ++i) {
    const BlockState& state = layout.block_state(i);
    const int k = layout.core_size() + i;
    belief_.mean.block[i] = state.initial;
    belief_.P(k, k) = state.initial_sigma * state.initial_sigma;
  }
  ekf::release(belief_, layout, settings_.velocity_sigma, settings_.rate_sigma);
  for (const SensorRecord& record : sensors)
    sensors_.push_back(measures_motion(record) ? record.state.sensor->clone() : nullptr);
}

/// The error δ of the state propagates by F, and with it its covariance with every point.
void DeadReckoning::predict(Time to) {
  if (!has_moved_) {
    belief_.stamp = to;  // as the filter: it starts at the first motion measurement
    return;
  }
  const double dt = to_seconds(to - belief_.stamp);
  way_ += belief_.mean.v_base.norm() * dt;
  const ErrorMatrix F = process_.transition(belief_.mean, dt);
  for (Point& point : points_) point.with_state = (F * point.with_state).eval();
  process_.predict(belief_, to, standstill_.standing());
}

void DeadReckoning::process(const Measurement& m) {
  if (!sensors_[m.sensor] || m.stamp < belief_.stamp) return;
  const auto later = std::ranges::upper_bound(waiting_, m.stamp, {}, &Measurement::stamp);
  waiting_.insert(later, m);
}

void DeadReckoning::advance(Time to) {
  while (!waiting_.empty() && waiting_.front().stamp <= to) {
    process_motion(waiting_.front());
    waiting_.pop_front();
  }
  predict(to);
}

void DeadReckoning::process_motion(const Measurement& m) {
  std::unique_ptr<Sensor>& sensor = sensors_[m.sensor];
  if (!sensor) return;
  predict(m.stamp);
  const StateLayout& layout = process_.layout();
  const int block_offset = layout.block_offset(static_cast<int>(m.sensor));
  const double* block = belief_.mean.block.data() + block_offset;
  updates_.clear();
  try {
    sensor->process(m, {belief_, layout, block, nullptr, standstill_.standing()}, updates_);
    has_moved_ = has_moved_ || sensor->traits().is_motion_source;
    if (!has_moved_) return;
    set_standing(m, updates_);
    const bool has_states = !layout.owners()[m.sensor].block.empty();
    if (standstill_.standing() && sensor->traits().is_motion_source && !has_states) {
      measures_speed_ = measures_speed_ || updates_.motion() != UpdateList::Motion::not_reported;
      return;
    }
    for (std::size_t i = 0; i < updates_.size(); ++i) update(block_offset, updates_[i]);
  } catch (const DataError&) {
    return;
  } catch (...) {
    sensor = nullptr;  // the filter reports it, when it processes the same measurement
  }
}

void DeadReckoning::set_standing(const Measurement& m, const UpdateList& updates) {
  const bool was_standing = standstill_.standing();
  if (updates.motion() != UpdateList::Motion::not_reported) {
    const bool is_whole_twist = updates.twist_reset().has_value();
    standstill_.report(m.sensor, m.stamp,
                       {.moving = updates.motion() == UpdateList::Motion::moving,
                        .measures_velocity = is_whole_twist || measures_speed_,
                        .until_next = is_whole_twist});
  }
  const StateLayout& layout = process_.layout();
  const bool stands = standstill_.standing();
  if (!was_standing && stands) {
    ekf::stop(belief_, layout);
  } else if (was_standing && !stands) {
    ekf::release(belief_, layout, settings_.velocity_sigma, settings_.rate_sigma);
  } else if (!stands && updates.twist_reset()) {
    ekf::release(belief_, layout, updates.twist_reset()->velocity_sigma, updates.twist_reset()->rate_sigma);
  } else {
    return;
  }
  forget_twist();
}

/// What replaced the twist is independent of the points.
void DeadReckoning::forget_twist() {
  for (int core = 6; core < kCoreStates; ++core) {
    const int k = process_.layout().active(core);
    if (k < 0) continue;
    for (Point& point : points_) point.with_state.row(k).setZero();
  }
}

/// Without a gate: nothing is known of the first twist, and a motion that is gated would be left out of the path.
void DeadReckoning::update(int block_offset, const Update& update) {
  const StateLayout& layout = process_.layout();
  Linearization model;
  estimation::StateJacobian H;
  ekf::Innovation innovation;
  update.linearize({belief_.mean, belief_.mean.block.data() + block_offset}, model);
  measures_speed_ = measures_speed_ || estimation::observes_speed(model);
  H.reset(model.rows(), layout.size());
  estimation::scatter(layout, block_offset, model, H);
  ekf::innovate(belief_, model, H, innovation);
  if (!innovation.finite) return;
  // δ ← (I − K H) δ: the covariance with a point loses K H C, but for the states that the update does not estimate.
  ekf::Innovation::Gain W = innovation.PHt;
  gaussian::divide_by_factor(W, innovation.L);
  for (Point& point : points_) {
    Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxUpdateRows, 2> HC(model.rows(), 2);
    HC.setZero();
    for (int k = 0; k < H.count; ++k)
      HC += H.columns.col(k) * point.with_state.row(H.states[static_cast<std::size_t>(k)]);
    innovation.L.triangularView<Eigen::Lower>().solveInPlace(HC);
    const ekf::Innovation::Gain kept = point.with_state.middleRows(innovation.first_considered, innovation.considered);
    point.with_state -= W * HC;
    point.with_state.middleRows(innovation.first_considered, innovation.considered) = kept;
  }
  ekf::apply(belief_, layout, innovation);
}

void DeadReckoning::add_fix(const Measurement& m, const StartHint& hint) {
  if (m.stamp < belief_.stamp || !hint.p_map_point) return;
  advance(m.stamp);
  const auto sensor = static_cast<int>(m.sensor);
  if (!has_moved_) {
    // The path begins at the first motion measurement: of the fixes before it the newest counts.
    const auto before = std::ranges::find(points_, sensor, [](const Point& p) { return p.fix.sensor; });
    if (before != points_.end()) {
      before->fix.stamp = m.stamp;
      before->fix.p_map = hint.p_map_point->head<2>();
      return;
    }
  }
  const StateLayout& layout = process_.layout();
  const Eigen::Vector3d arm = belief_.mean.T_map_base.q * hint.p_base_point;
  Linearization model;
  model.reset(2, 0);
  model.position() = Eigen::Matrix3d::Identity().topRows<2>();
  if (!arm.isZero(0.0)) model.attitude() = -so3::skew(arm).topRows<2>();
  estimation::StateJacobian H;
  H.reset(2, layout.size());
  estimation::scatter(layout, 0, model, H);

  Point point;
  point.fix.stamp = m.stamp;
  point.fix.p_map = hint.p_map_point->head<2>();
  point.fix.p_local = (belief_.mean.T_map_base.p + arm).head<2>();
  point.fix.sensor = sensor;
  point.fix.slow_sigma_m = hint.slow_sigma_m;
  point.fix.slow_tau_s = hint.slow_tau_s;
  point.fix.sigma_m = std::sqrt(std::max(hint.sigma_m * hint.sigma_m - hint.slow_sigma_m * hint.slow_sigma_m, 0.0));
  point.with_state = ekf::project(belief_.P, H);

  const auto project = [&](const ekf::Innovation::Gain& with_state) {
    Eigen::Matrix2d out = Eigen::Matrix2d::Zero();
    for (int k = 0; k < H.count; ++k) out += H.columns.col(k) * with_state.row(H.states[static_cast<std::size_t>(k)]);
    return out;
  };
  const auto n = static_cast<Eigen::Index>(points_.size());
  joint_.conservativeResize(2 * n + 2, 2 * n + 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Matrix2d cross = project(points_[static_cast<std::size_t>(i)].with_state);
    joint_.block<2, 2>(2 * n, 2 * i) = cross;
    joint_.block<2, 2>(2 * i, 2 * n) = cross.transpose();
  }
  joint_.block<2, 2>(2 * n, 2 * n) = project(point.with_state);
  points_.push_back(std::move(point));
  if (points_.size() > kMostPoints) thin_out();
}

/// Drops every second point of each sensor, but not the last ones.
void DeadReckoning::thin_out() {
  std::vector<Eigen::Index> kept;
  std::vector<int> seen(sensors_.size(), 0);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const bool is_odd = seen[static_cast<std::size_t>(points_[i].fix.sensor)]++ % 2 == 1;
    if (!is_odd || i + 1 == points_.size()) kept.push_back(static_cast<Eigen::Index>(i));
  }
  const auto n = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd joint(2 * n, 2 * n);
  std::vector<Point> points;
  points.reserve(kept.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index from = kept[static_cast<std::size_t>(i)];
    points.push_back(points_[static_cast<std::size_t>(from)]);
    for (Eigen::Index j = 0; j < n; ++j) {
      joint.block<2, 2>(2 * i, 2 * j) = joint_.block<2, 2>(2 * from, 2 * kept[static_cast<std::size_t>(j)]);
    }
  }
  points_ = std::move(points);
  joint_ = std::move(joint);
}

std::optional<estimation::HeadingFit> DeadReckoning::heading(double least_distance) const {
  const bool is_apart = std::ranges::any_of(points_, [&](const Point& point) {
    return (point.fix.p_local - points_.front().fix.p_local).norm() >= least_distance;
  });
  if (!is_apart) return std::nullopt;
  std::vector<estimation::ReckonedFix> fixes;
  fixes.reserve(points_.size());
  for (const Point& point : points_) fixes.push_back(point.fix);
  return estimation::fit_heading(fixes, joint_);
}

}  // namespace waymark::fusion
