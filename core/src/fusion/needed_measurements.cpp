// SPDX-License-Identifier: Apache-2.0
#include "fusion/needed_measurements.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::fusion {

void NeededMeasurements::offer(const Measurement& m) {
  const auto place = places_.find({m.sensor, m.sequence});
  if (place != places_.end()) found_[place->second] = m;
}

void NeededMeasurements::prepare() {
  places_.clear();
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (!places_.emplace(keys_[i], i).second) throw DataError("the checkpoint needs a measurement twice");
  }
  found_.assign(keys_.size(), {});
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
