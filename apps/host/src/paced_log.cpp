// SPDX-License-Identifier: Apache-2.0
#include "paced_log.hpp"

namespace waymark::host {

std::optional<Measurement> PacedLog::next() {
  std::optional<Measurement> measurement = log_->next();
  if (!measurement) return std::nullopt;
  if (!is_stamp(measurement->arrival)) return measurement;  // the filter counts it
  if (!shift_) shift_ = clock_->now() - measurement->arrival;
  measurement->stamp = moved(measurement->stamp, *shift_).value_or(Time::max());
  measurement->arrival = moved(measurement->arrival, *shift_).value_or(Time::max());
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    const Duration early = measurement->arrival - clock_->now();
    if (early <= Duration::zero()) return measurement;
    wake_.wait_for(lock, early);
  }
  return std::nullopt;
}

void PacedLog::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  wake_.notify_all();
}

}  // namespace waymark::host
