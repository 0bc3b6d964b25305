// SPDX-License-Identifier: Apache-2.0
#include "fusion/measurement_queue.hpp"

#include <algorithm>
#include <tuple>

#include "waymark/base/error.hpp"

namespace waymark::fusion {

namespace {

auto key(const Measurement& m) { return std::tie(m.stamp, m.sensor, m.sequence); }

}  // namespace

bool MeasurementQueue::Order::operator()(const Measurement& a, const Measurement& b) const { return key(a) < key(b); }

bool MeasurementQueue::push(const Measurement& measurement) {
  newest_arrival_ = std::max(newest_arrival_, measurement.arrival);
  if (key(measurement) < handed_out_) return false;
  waiting_.insert(measurement);
  return true;
}

void MeasurementQueue::put_back(Measurement&& measurement) {
  if (key(measurement) < handed_out_) throw DataError("the checkpoint has a waiting measurement that was processed");
  waiting_.insert(std::move(measurement));
}

std::optional<Measurement> MeasurementQueue::pop_due() {
  // Strictly older: a measurement with an equal stamp may still come, and the YAML's order of sensors decides between
  // them.
  if (waiting_.empty() || newest_arrival_ - waiting_.begin()->stamp <= max_latency_) return std::nullopt;
  return pop();
}

std::optional<Measurement> MeasurementQueue::pop() {
  if (waiting_.empty()) return std::nullopt;
  Measurement oldest = std::move(waiting_.extract(waiting_.begin()).value());
  handed_out_ = key(oldest);
  return oldest;
}

}  // namespace waymark::fusion
