// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "waymark/host/diagnosis.hpp"

namespace waymark::host {

/// Gives a diagnosis measurements in the order in which they arrive.
class MeasurementFeed {
 public:
  explicit MeasurementFeed(Diagnosis& diagnosis) : diagnosis_(diagnosis) {}

  /// `t`: stamp and arrival [s].
  void pass(std::uint32_t sensor, double t, std::shared_ptr<Payload> payload) {
    Measurement measurement;
    measurement.stamp = measurement.arrival = Time{} + from_seconds(t);
    measurement.sensor = sensor;
    measurement.sequence = sequence_++;
    measurement.payload = std::move(payload);
    diagnosis_.arrived(measurement);
  }

 private:
  Diagnosis& diagnosis_;
  std::uint64_t sequence_ = 0;
};

}  // namespace waymark::host
