// SPDX-License-Identifier: Apache-2.0
#include "fusion/needed_measurements.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::fusion {

void NeededMeasurements::offer(const Measurement& m) {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (keys_[i] == std::pair(m.sensor, m.sequence)) found_[i] = m;
  }
}

void NeededMeasurements::check() const {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (found_[i].payload == nullptr) {
      throw DataError(
          fmt::format("the log lacks measurement {} that the checkpoint needs: it is another log", keys_[i].second));
    }
  }
}

void NeededMeasurements::save(OutArchive& out) const {
  out.value(static_cast<std::uint64_t>(keys_.size()));
  for (const auto& [sensor, sequence] : keys_) {
    out.value(sensor);
    out.value(sequence);
  }
}

void NeededMeasurements::load(InArchive& in) {
  std::uint64_t count = 0;
  in.value(count);
  keys_.clear();
  for (std::uint64_t i = 0; i < count; ++i) {
    auto& [sensor, sequence] = keys_.emplace_back();
    in.value(sensor);
    in.value(sequence);
  }
  found_.assign(keys_.size(), {});
}

}  // namespace waymark::fusion
