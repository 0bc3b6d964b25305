// SPDX-License-Identifier: Apache-2.0
// Runs the contract kit on the module, and checks what is drawn.
#include <algorithm>
#include <cstdio>
#include <numbers>

#include "radar_map.cpp"
#include "waymark/testing/map_module_contract.hpp"

using namespace waymark;

namespace {

constexpr double kSpeed = 2.0;

/// A post at (10, 1) that stands, and a thing at (8, −2) that moves, seen from `x` at 2 m/s.
std::shared_ptr<RadarTargets> scan_from(double x) {
  auto scan = std::make_shared<RadarTargets>();
  const auto add = [&](double px, double py, double of_its_own) {
    const Eigen::Vector2d d(px - x - 0.5, py);
    RadarTargets::One& one = scan->targets.emplace_back();
    one.range_m = d.norm();
    one.azimuth_rad = std::atan2(d.y(), d.x());
    one.radial_mps = -kSpeed * std::cos(one.azimuth_rad) + of_its_own;
  };
  add(10.0, 1.05, 0.0);
  add(8.0, -2.0, 3.0);
  return scan;
}

int percent_at(const GridView& grid, double x, double y) {
  const Eigen::Vector3d p = grid.T_map_grid.inverse() * Eigen::Vector3d(x, y, 0.0) / grid.resolution_m;
  const auto column = static_cast<int>(std::floor(p.x()));
  const auto row = static_cast<int>(std::floor(p.y()));
  if (column < 0 || row < 0 || column >= grid.width || row >= grid.height) return GridView::kUnknown;
  return grid.cells[static_cast<std::size_t>(row * grid.width + column)];
}

int failed(bool holds, const char* what) {
  if (!holds) std::fprintf(stderr, "failed: %s\n", what);
  return holds ? 0 : 1;
}

}  // namespace

int main() {
  const Config config = Config::parse("{ inputs: [front] }");
  radar_map::RadarMap module(config, Rig({{"front", "waymark/RadarTargets@1", Pose::planar(0.5, 0.0, 0.0)}}));
  config.reject_unread();
  std::vector<testing::MappingStep> steps(20);
  const auto map = module.create_map();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double x = 0.1 * static_cast<double>(i);
    testing::MappingStep& step = steps[i];
    step.trigger.stamp = step.trigger.arrival = Time(std::chrono::milliseconds(50 * i));
    step.trigger.sequence = i;
    step.trigger.payload = scan_from(x);
    step.T_map_base = Pose::planar(x, 0.0, 0.0);
    step.motion.v_base.x() = kSpeed;
    step.motion.T_map_base = step.T_map_base;
    map->insert({step.T_map_base}, *module.extract(step.trigger, {}, step.motion), nullptr);
  }
  const testing::Violations found = testing::check_map_module(module, steps);
  std::fputs(testing::to_text(found).c_str(), stderr);
  const GridView grid = map->grid().value();
  return failed(found.empty(), "the contract") + failed(percent_at(grid, 10.0, 1.05) >= 99, "the post is drawn") +
         failed(percent_at(grid, 8.0, -2.0) == GridView::kUnknown, "what moves is not drawn");
}
