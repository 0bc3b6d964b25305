// SPDX-License-Identifier: Apache-2.0
#include "fusion/sensor_record.hpp"

#include "waymark/base/error.hpp"

namespace waymark::fusion {

SensorState SensorState::clone() const {
  SensorState copy = *this;
  if (copy.sensor) copy.sensor = copy.sensor->clone();
  return copy;
}

void SensorState::save(OutArchive& out) const {
  fuse.save(out);
  out.bytes(&counters, sizeof counters);
  for (const int rejections : rejections_in_a_row) out.value(rejections);
  bias.save(out);
  out.value(biased);
  out.value(ignored_noted);
  out.value(not_localized_noted);
  out.value(sensor != nullptr);
  if (sensor) sensor->save(out);
}

void SensorState::load(InArchive& in) {
  fuse.load(in);
  in.bytes(&counters, sizeof counters);
  for (int& rejections : rejections_in_a_row) in.value(rejections);
  bias.load(in);
  in.value(biased);
  in.value(ignored_noted);
  in.value(not_localized_noted);
  bool in_service = false;
  in.value(in_service);
  if (in_service && !sensor) throw DataError("the checkpoint has a sensor in service that the configuration lacks");
  if (!in_service) sensor = nullptr;
  if (sensor) sensor->load(in);
}

}  // namespace waymark::fusion
