// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "waymark/base/api.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::fusion {

/// Puts measurements in the total order of (stamp, sensor, sequence). A measurement is due once its stamp lies more
/// than `max_latency` behind the newest arrival, so the order of arrival within that window has no effect.
class WAYMARK_API MeasurementQueue {
 public:
  explicit MeasurementQueue(Duration max_latency) : max_latency_(max_latency) {}

  /// Adds `measurement`. False if it precedes, in the total order, one that was already returned.
  bool push(const Measurement& measurement);
  /// The oldest measurement that is due, if any.
  std::optional<Measurement> pop_due();
  /// The oldest measurement, due or not: for the end of the log.
  std::optional<Measurement> pop();

  /// Stamp of the newest measurement that was returned; the earliest time if none was.
  Time newest_returned() const { return std::get<Time>(handed_out_); }

  std::size_t size() const { return waiting_.size(); }

  /// All but the waiting measurements, for a checkpoint; they are restored with `put_back`.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(newest_arrival_, std::get<0>(handed_out_), std::get<1>(handed_out_), std::get<2>(handed_out_));
  }
  /// Throws DataError if it precedes one that was returned.
  void put_back(Measurement&& measurement);

  /// The total order.
  struct Order {
    bool operator()(const Measurement& a, const Measurement& b) const;
  };
  /// The buffered measurements, in order.
  const std::multiset<Measurement, Order>& waiting() const { return waiting_; }

 private:
  Duration max_latency_;
  Time newest_arrival_ = Time::min();
  std::tuple<Time, std::uint32_t, std::uint64_t> handed_out_{Time::min(), 0, 0};
  std::multiset<Measurement, Order> waiting_;
};

}  // namespace waymark::fusion
