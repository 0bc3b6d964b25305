// SPDX-License-Identifier: Apache-2.0
#include "fusion/sensor_record.hpp"

namespace waymark::fusion {

SensorState SensorState::clone() const {
  SensorState copy = *this;
  if (copy.sensor) copy.sensor = copy.sensor->clone();
  return copy;
}

}  // namespace waymark::fusion
