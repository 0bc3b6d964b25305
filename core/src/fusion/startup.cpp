// SPDX-License-Identifier: Apache-2.0
#include "fusion/startup.hpp"

#include <algorithm>

#include "fusion/measurement_queue.hpp"
#include "fusion/setup.hpp"

namespace waymark::fusion {

std::optional<Start> Startup::process(const Measurement& m, const std::optional<StartHint>& hint,
                                      const std::vector<SensorRecord>& sensors) {
  buffer_.insert(std::upper_bound(buffer_.begin(), buffer_.end(), m, MeasurementQueue::Order{}), m);
  if (!start_) start_ = finder_.process(m, hint);
  if (!start_) return std::nullopt;
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
  start_->prior.stamp = first_motion->stamp;
  return start_;
}

std::string Startup::missing() const {
  if (!start_) return finder_.missing();
  return motion_from_maps_ ? "no map has received a measurement" : "no motion sensor has delivered a measurement";
}

}  // namespace waymark::fusion
