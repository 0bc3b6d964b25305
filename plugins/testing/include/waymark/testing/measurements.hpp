// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "waymark/interface/measurement.hpp"

namespace waymark::testing {

/// `count` measurements of one sensor with payload P, `interval_s` apart from stamp 100 s on, each arrived at its
/// stamp. `fill(payload, t)` sets the payload; t counts from 0 [s].
template <class P, class Fill>
std::vector<Measurement> measurements_of(int count, double interval_s, const Fill& fill) {
  std::vector<Measurement> measurements;
  measurements.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    const double t = interval_s * k;
    auto payload = std::make_shared<P>();
    fill(*payload, t);
    Measurement m;
    m.stamp = m.arrival = Time(std::chrono::nanoseconds(std::llround(1e9 * (100.0 + t))));
    m.sequence = static_cast<std::uint64_t>(k);
    m.payload = std::move(payload);
    measurements.push_back(std::move(m));
  }
  return measurements;
}

}  // namespace waymark::testing
