// SPDX-License-Identifier: Apache-2.0
#include "fusion/needed_measurements.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::fusion {

void NeededMeasurements::offer(const Measurement& m) {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (keys_[i] == Key{m.sensor, m.sequence}) found_[i] = m;
  }
}

void NeededMeasurements::check() const {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (found_[i].payload == nullptr) {
      throw DataError(
          fmt::format("the log lacks measurement {} that the checkpoint needs: it is another log", keys_[i].sequence));
    }
  }
}

}  // namespace waymark::fusion
