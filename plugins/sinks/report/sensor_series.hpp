// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "waymark/interface/snapshot.hpp"

namespace waymark::report {

/// The counters of all sensors over time. They are sums since the start, so that rows can be left out without a loss:
/// the difference of two rows is what happened in between. Evenly spread over the time of the log, bounded like Track.
class SensorSeries {
 public:
  static constexpr std::size_t kMost = 1024;
  /// Sums since the start of the run.
  struct Sums {
    std::uint64_t used = 0;
    std::uint64_t rejected = 0;
    double nis = 0.0;
    std::uint64_t nis_dof = 0;
  };
  struct Row {
    Time stamp{};
    std::vector<Sums> sensors;
  };

  void add(const Snapshot& snapshot) {
    const std::uint32_t sensor = snapshot.measurement().sensor;
    if (sensor >= now_.size()) now_.resize(sensor + 1);
    const SensorCounters& counters = snapshot.counters();
    now_[sensor] = {counters.fused + counters.mapped, counters.gated + counters.unusable, counters.nis_sum,
                    counters.nis_dof};
    const Time stamp = snapshot.stamp();
    if (!rows_.empty() && (stamp <= rows_.back().stamp || stamp - rows_.back().stamp < interval_)) return;
    rows_.push_back({stamp, now_});
    if (rows_.size() < kMost) return;
    for (std::size_t i = 1; 2 * i < rows_.size(); ++i) rows_[i] = std::move(rows_[2 * i]);
    rows_.resize((rows_.size() + 1) / 2);
    interval_ = std::max<Duration>(2 * interval_, (rows_.back().stamp - rows_.front().stamp) / (kMost / 2));
  }
  /// Adds what happened since the last row.
  void finish(Time stamp) {
    if (!now_.empty() && (rows_.empty() || stamp > rows_.back().stamp)) rows_.push_back({stamp, now_});
  }

  const std::vector<Row>& rows() const { return rows_; }

 private:
  std::vector<Sums> now_;
  std::vector<Row> rows_;
  Duration interval_{};
};

}  // namespace waymark::report
