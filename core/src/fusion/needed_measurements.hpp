// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "waymark/interface/measurement.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::fusion {

/// Measurements that a checkpoint needs, by (sensor, sequence), in the order in which they were wanted: it holds none,
/// but reads them from the log again, which is exact and needs no format of its own.
class NeededMeasurements {
 public:
  void want(const Measurement& m) { keys_.emplace_back(m.sensor, m.sequence); }
  /// Keeps `m` if it is wanted.
  void offer(const Measurement& m);
  /// Throws DataError if the log did not hold them all.
  void check() const;
  std::vector<Measurement>& found() { return found_; }

  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  std::vector<std::pair<std::uint32_t, std::uint64_t>> keys_;
  std::vector<Measurement> found_;
};

}  // namespace waymark::fusion
