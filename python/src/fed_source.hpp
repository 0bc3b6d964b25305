// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/interface/source.hpp"

namespace waymark::python {

/// The source of a robot that the program feeds: delivers what was added so far, in order of arrival, equal arrivals in
/// the order of the sensors. Its channels are the robot's sensors.
class FedSource final : public Source {
 public:
  explicit FedSource(std::vector<std::string> sensors);

  /// Appends measurements of one sensor, in order of arrival.
  void add(std::size_t sensor, std::vector<Measurement> block);
  /// Arrival of the last measurement that was added for a sensor; nothing if there was none.
  std::optional<Time> last_arrival(std::size_t sensor) const { return last_arrivals_[sensor]; }
  std::uint64_t waiting() const;

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override;

 private:
  std::vector<Channel> channels_;
  std::vector<std::deque<Measurement>> queues_;  // by sensor
  std::vector<std::optional<Time>> last_arrivals_;
  std::uint64_t delivered_ = 0;
};

}  // namespace waymark::python
