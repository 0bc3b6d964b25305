// SPDX-License-Identifier: Apache-2.0
// Runs the contract kit on our sensor: prints all violations, and fails if there is one.
#include <cstdio>

#include "beacon_range.cpp"
#include "waymark/testing/sensor_contract.hpp"

int main() {
  const Config config = Config::parse("{ map_p_beacon_m: [40, -20], base_p_antenna_m: [0.3, 0.1, 0.5], sigma_m: 0.1 }");
  const BeaconRangeSensor sensor(config);
  std::vector<Measurement> measurements(20);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    auto range = std::make_shared<BeaconRange>();
    range->range_m = 30.0 + static_cast<double>(i);
    measurements[i].stamp = measurements[i].arrival = Time(std::chrono::milliseconds(100 * i));
    measurements[i].sequence = i;
    measurements[i].payload = std::move(range);
  }
  const testing::Violations found = testing::check_sensor(sensor, measurements, StateLayout::Motion::spatial);
  std::fputs(testing::to_text(found).c_str(), stderr);
  return found.empty() ? 0 : 1;
}
