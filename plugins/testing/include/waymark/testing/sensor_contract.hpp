// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "waymark/interface/sensor.hpp"
#include "waymark/testing/violations.hpp"

namespace waymark::testing {

/// Under which circumstances a sensor is checked.
struct SensorSetting {
  NavState center;  ///< random states are drawn around it (10 m, 0.3 rad roll and pitch, any yaw, 2 m/s, 1 rad/s); its
                    ///< `block` is ignored
  std::optional<Datum> datum;  ///< the map's origin on the Earth, for sensors that need one
  int states = 8;              ///< random states per measurement whose Jacobians are looked at
  std::uint64_t seed = 1;      ///< of the states
};

/// Runs `measurements` (in stamp order, about 10 to 1000 as a robot in motion gives them) through clones of `sensor`,
/// which itself is left alone, and checks
/// - the sensor's own states: names, sigmas, walks;
/// - every update: shapes, finite values, R symmetric and positive definite, Jacobians against central differences on
/// the
///   manifold (1e-6 of the largest entry of the row);
/// - `linearize`: same input, same bytes, whatever `out` held before and from several threads at once;
/// - `process` and `outcome`: the same on every clone; a clone takes the state along and shares nothing that changes;
/// - `save` and `load`: the loaded sensor, fresh or used, continues identically; a stream that ends early is refused;
/// - a foreign payload is refused with DataError, the start hint is finite;
/// - NaN and infinity in each number that the payload registers: DataError, no update, or a finite one; where the
/// payload itself counts as bad (`Payload::problem`: no source passes it on), also an update that is not finite, which
/// the host rejects. The next good measurements give finite updates again. The payloads are changed meanwhile.
Violations check_sensor(const Sensor& sensor, std::span<const Measurement> measurements, StateLayout::Motion motion,
                        const SensorSetting& setting = {});

}  // namespace waymark::testing
