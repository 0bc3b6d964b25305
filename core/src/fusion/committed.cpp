// SPDX-License-Identifier: Apache-2.0
#include "fusion/committed.hpp"

#include <string>

#include "waymark/base/error.hpp"

namespace waymark::fusion {

Committed Committed::clone() const {
  Committed copy = *this;
  for (SensorState& state : copy.sensors) {
    if (state.sensor) state.sensor = state.sensor->clone();
  }
  return copy;
}

void Committed::save(OutArchive& out) const {
  out.section("committed", 3);
  out.value(static_cast<std::uint64_t>(sensors.size()));
  for (const SensorState& state : sensors) {
    state.fuse.save(out);
    out.bytes(&state.counters, sizeof state.counters);
    for (const int rejections : state.rejections_in_a_row) out.value(rejections);
    state.bias.save(out);
    out.value(state.biased);
    out.value(state.told_unheard);
    out.value(state.told_elsewhere);
    out.value(state.sensor != nullptr);
    if (state.sensor) state.sensor->save(out);
  }
  standstill.save(out);
  health.save(out);
  out.value(static_cast<std::uint64_t>(events));
  out.value(static_cast<std::uint64_t>(smoothed));
  out.value(last_stamp);
}

void Committed::load(InArchive& in) {
  if (in.section("committed", 3) < 3) throw DataError("the checkpoint is of an older kind");
  std::uint64_t count = 0;
  in.value(count);
  if (count != sensors.size()) {
    throw DataError("the checkpoint has " + std::to_string(count) + " sensors, the configuration " +
                    std::to_string(sensors.size()));
  }
  for (SensorState& state : sensors) {
    state.fuse.load(in);
    in.bytes(&state.counters, sizeof state.counters);
    for (int& rejections : state.rejections_in_a_row) in.value(rejections);
    state.bias.load(in);
    in.value(state.biased);
    in.value(state.told_unheard);
    in.value(state.told_elsewhere);
    bool in_service = false;
    in.value(in_service);
    if (in_service && !state.sensor) {
      throw DataError("the checkpoint has a sensor in service that the configuration lacks");
    }
    if (!in_service) state.sensor = nullptr;
    if (state.sensor) state.sensor->load(in);
  }
  standstill.load(in);
  health.load(in);
  for (std::size_t* size : {&events, &smoothed}) {
    std::uint64_t value = 0;
    in.value(value);
    *size = static_cast<std::size_t>(value);
  }
  in.value(last_stamp);
}

}  // namespace waymark::fusion
