// SPDX-License-Identifier: Apache-2.0
#include "simulated_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace waymark::simulator {

SimulatedSensor::SimulatedSensor(const Config& config, std::string_view payload_type, double default_rate_hz,
                                 double phase)
    : channel_{config.text({"sensor", "its name under `sensors`"}), std::string(payload_type)},
      rate_hz_(config.number_in({"rate_hz", "Hz", "measurements per second"}, 0.001, 10000.0, default_rate_hz)),
      phase_(phase),
      faults_(config, payload_type, static_cast<std::uint32_t>(std::lround(100.0 * phase))) {}

Duration SimulatedSensor::next_time() const { return from_seconds((static_cast<double>(taken_) + phase_) / rate_hz_); }

Sample SimulatedSensor::measure(const Truth& truth) {
  const Duration time = next_time();
  // A sensor that is dead lives on inside: its errors are what they would have been.
  std::shared_ptr<Payload> payload = sample(truth, time);
  if (faults_.dead(time)) payload = nullptr;
  if (payload) faults_.spoil(truth.seed, time, *payload);
  ++taken_;
  return {time, faults_.stamp(time), faults_.arrival(truth.seed, time), std::move(payload)};
}

std::vector<SimulatedSensor::Underway>::iterator SimulatedSensor::first_to_arrive() {
  return std::ranges::min_element(
      underway_, {}, [](const Underway& one) { return one.delivered ? Duration::max() : one.sample.arrival; });
}

Duration SimulatedSensor::next_arrival(const Truth& truth, Duration end) {
  if (!faults_.reorder()) return next_time() > end ? Duration::max() : next_time() + faults_.least_delay();
  // Whatever could still overtake the first one must have been measured.
  while (next_time() <= end) {
    if (!underway_.empty() && first_to_arrive()->sample.arrival < next_time() + faults_.least_delay()) break;
    underway_.push_back({.sample = measure(truth)});
  }
  return underway_.empty() ? Duration::max() : first_to_arrive()->sample.arrival;
}

Sample SimulatedSensor::take(const Truth& truth) {
  if (!faults_.reorder()) return measure(truth);
  const auto first = first_to_arrive();
  first->delivered = true;
  Sample sample = std::move(first->sample);
  const auto waiting = std::ranges::find(underway_, false, &Underway::delivered);
  underway_.erase(underway_.begin(), waiting);
  return sample;
}

}  // namespace waymark::simulator
