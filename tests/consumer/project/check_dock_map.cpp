// SPDX-License-Identifier: Apache-2.0
// Runs the contract kit on our map module: prints all violations, and fails if there is one.
#include <cstdio>

#include "dock_map.cpp"
#include "waymark/testing/map_module_contract.hpp"

int main() {
  const Config config = Config::parse("{ inputs: [camera], sigma_m: 0.05 }");
  DockMapModule module(config, Rig({{"camera", "waymark/LandmarkObservations@1", Pose::planar(0.2, 0.0, 0.1)}}));
  std::vector<testing::MappingStep> steps(20);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    auto seen = std::make_shared<LandmarkObservations>();
    seen->landmarks.emplace_back();
    seen->landmarks.back().range_m = 3.0 + 0.01 * static_cast<double>(i);
    seen->landmarks.back().bearing_rad = 0.3;
    steps[i].trigger.stamp = steps[i].trigger.arrival = Time(std::chrono::milliseconds(200 * i));
    steps[i].trigger.sequence = i;
    steps[i].trigger.payload = std::move(seen);
    steps[i].T_map_base = Pose::planar(-0.01 * static_cast<double>(i), 0.0, 0.0);
  }
  const testing::Violations found = testing::check_map_module(module, steps);
  std::fputs(testing::to_text(found).c_str(), stderr);
  return found.empty() ? 0 : 1;
}
