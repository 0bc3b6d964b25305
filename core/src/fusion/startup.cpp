// SPDX-License-Identifier: Apache-2.0
#include "fusion/startup.hpp"

#include <algorithm>
#include <numbers>

#include "fusion/measurement_queue.hpp"
#include "fusion/setup.hpp"

namespace waymark::fusion {

std::optional<Start> Startup::process(const Measurement& m, const std::optional<StartHint>& hint,
                                      const std::vector<SensorRecord>& sensors) {
  buffer_.insert(std::upper_bound(buffer_.begin(), buffer_.end(), m, MeasurementQueue::Order{}), m);
  if (!start_ && !(last_pose_ && !sources_.has_absolute)) start_ = finder_.process(m, hint, sensors, buffer_);
  if (!start_ && last_pose_ && has_waited_enough(m)) start_ = last_pose_->start;
  if (!start_) return std::nullopt;
  if (auto start = at_first_motion(sensors)) return start;
  // Better a pose without a motion sensor than none.
  if (!last_pose_ || m.stamp - last_pose_->start.prior.stamp <= last_pose_->patience) return std::nullopt;
  start_->prior.stamp = std::max(start_->prior.stamp, buffer_.back().stamp);
  return start_;
}

bool Startup::has_waited_enough(const Measurement& m) const {
  if (!sources_.has_absolute) return true;
  // With a position the heading follows as soon as the robot drives; maps can find it, too.
  if (finder_.has_position() && !last_pose_->has_maps) return false;
  return m.stamp - last_pose_->start.prior.stamp > last_pose_->patience;
}

std::optional<Start> Startup::at_first_motion(const std::vector<SensorRecord>& sensors) const {
  // The filter starts at the first motion measurement. The twist before it is unknown, and one second of prediction
  // with it would rotate the map.
  const auto first_motion = std::ranges::find_if(buffer_, [&](const Measurement& b) {
    const SensorRecord& record = sensors[b.sensor];
    const Sensor* sensor = record.state.sensor.get();
    const bool is_motion =
        motion_from_maps_ ? record.triggers_map : sensor != nullptr && record.traits.is_motion_source;
    return b.stamp >= start_->prior.stamp && is_motion && is_fused_after_start(record.slot);
  });
  if (first_motion == buffer_.end()) return std::nullopt;
  std::optional<Start> start = start_;
  start->prior.stamp = first_motion->stamp;
  return start;
}

void Startup::search_again(Start last_pose, Duration patience, bool has_maps) {
  constexpr double kYawSigma = 10.0 * std::numbers::pi / 180.0;  // the default of initial.yaw_sigma_deg
  StartSettings settings = settings_;
  settings.position.reset();
  settings.yaw.reset();
  settings.yaw_sigma = std::max(settings.yaw_sigma, kYawSigma);
  // The pose is uncertain in the maps that are there: their gauge is not free any more.
  StartSources sources = sources_;
  sources.fuses_absolute = true;
  finder_.restart(settings, sources);
  start_.reset();
  last_pose_ = {std::move(last_pose), patience, has_maps};
}

void Startup::give(const GivenPose& pose) {
  settings_.position = pose.position;
  settings_.position_sigma = pose.position_sigma;
  settings_.yaw = pose.yaw;
  settings_.yaw_sigma = pose.yaw_sigma;
  finder_.restart(settings_, sources_);
  start_.reset();
}

std::string Startup::missing() const {
  if (!start_) return finder_.missing();
  return motion_from_maps_ ? "no map has received a measurement" : "no motion sensor has delivered a measurement";
}

}  // namespace waymark::fusion
