// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "waymark/interface/measurement.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::fusion {

/// Measurements that a checkpoint needs, by (sensor, sequence), in the order of `want`. The checkpoint does not contain
/// them: they are read from the log again, which is exact and needs no format.
class NeededMeasurements {
 public:
  /// Adds a needed measurement.
  void want(const Measurement& m) {
    places_.emplace(Key{m.sensor, m.sequence}, keys_.size());
    keys_.push_back({m.sensor, m.sequence});
  }
  /// Stores `m` if it is needed.
  void offer(const Measurement& m);
  /// Throws DataError if one of them was not in the log.
  void check() const;
  /// The needed measurements that were read.
  std::vector<Measurement>& found() { return found_; }

  /// Reading throws DataError if one of them is listed twice.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(keys_);
    if constexpr (Archive::kReads) prepare();
  }

 private:
  struct Key {
    std::uint32_t sensor = 0;
    std::uint64_t sequence = 0;

    bool operator<(const Key& other) const {
      return std::tie(sensor, sequence) < std::tie(other.sensor, other.sequence);
    }
    template <class Archive>
    void serialize(Archive& archive) {
      archive(sensor, sequence);
    }
  };

  void prepare();

  std::vector<Key> keys_;
  std::map<Key, std::size_t> places_;  // in that list
  std::vector<Measurement> found_;
};

}  // namespace waymark::fusion
