// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "waymark/interface/measurement.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::fusion {

/// Measurements that a checkpoint needs, by (sensor, sequence), in the order in which they were wanted: it holds none,
/// but reads them from the log again, which is exact and needs no format of its own.
class NeededMeasurements {
 public:
  void want(const Measurement& m) { keys_.push_back({m.sensor, m.sequence}); }
  /// Keeps `m` if it is wanted.
  void offer(const Measurement& m);
  /// Throws DataError if the log did not hold them all.
  void check() const;
  std::vector<Measurement>& found() { return found_; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(keys_);
    if constexpr (Archive::kReads) found_.assign(keys_.size(), {});
  }

 private:
  struct Key {
    std::uint32_t sensor = 0;
    std::uint64_t sequence = 0;

    bool operator==(const Key&) const = default;
    template <class Archive>
    void serialize(Archive& archive) {
      archive(sensor, sequence);
    }
  };

  std::vector<Key> keys_;
  std::vector<Measurement> found_;
};

}  // namespace waymark::fusion
