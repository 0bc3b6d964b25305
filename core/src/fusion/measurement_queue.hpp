// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <tuple>

#include "waymark/base/api.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::fusion {

/// Puts measurements in time order: a total order of (stamp, sensor, sequence). A measurement is handed out once its
/// stamp lies more than `max_latency` behind the newest arrival, so the order does not depend on how measurements
/// overtook each other within that window.
class WAYMARK_API MeasurementQueue {
 public:
  explicit MeasurementQueue(Duration max_latency) : max_latency_(max_latency) {}

  /// Takes `measurement`, unless it comes, in the total order, before what was handed out already: then false.
  bool push(const Measurement& measurement);
  /// The oldest measurement that is due, if any.
  std::optional<Measurement> pop_due();
  /// The oldest measurement, due or not: for the end of the log.
  std::optional<Measurement> pop();

  std::size_t size() const { return waiting_.size(); }

  struct Order {
    bool operator()(const Measurement& a, const Measurement& b) const;
  };
  const std::multiset<Measurement, Order>& waiting() const { return waiting_; }

 private:
  Duration max_latency_;
  Time newest_arrival_ = Time::min();
  std::tuple<Time, std::uint32_t, std::uint64_t> handed_out_{Time::min(), 0, 0};
  std::multiset<Measurement, Order> waiting_;
};

}  // namespace waymark::fusion
