// SPDX-License-Identifier: Apache-2.0
#include "fed_source.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace waymark::python {

FedSource::FedSource(std::vector<std::string> sensors) : queues_(sensors.size()), last_arrivals_(sensors.size()) {
  channels_.reserve(sensors.size());
  for (std::string& sensor : sensors) channels_.push_back({std::move(sensor), {}});
}

void FedSource::add(std::size_t sensor, std::vector<Measurement> block) {
  if (block.empty()) return;
  last_arrivals_[sensor] = block.back().arrival;
  queues_[sensor].insert(queues_[sensor].end(), std::move_iterator(block.begin()), std::move_iterator(block.end()));
}

std::uint64_t FedSource::waiting() const {
  std::uint64_t count = 0;
  for (const auto& queue : queues_) count += queue.size();
  return count;
}

std::optional<Measurement> FedSource::next() {
  std::deque<Measurement>* earliest = nullptr;
  for (auto& queue : queues_) {
    if (!queue.empty() && (earliest == nullptr || queue.front().arrival < earliest->front().arrival)) earliest = &queue;
  }
  if (earliest == nullptr) return std::nullopt;
  Measurement measurement = std::move(earliest->front());
  earliest->pop_front();
  measurement.sequence = delivered_++;
  return measurement;
}

double FedSource::progress() const {
  const std::uint64_t all = delivered_ + waiting();
  return all == 0 ? -1.0 : static_cast<double>(delivered_) / static_cast<double>(all);
}

}  // namespace waymark::python
