// SPDX-License-Identifier: Apache-2.0
#include "surfaces_file.hpp"

#include <fmt/format.h>

#include <cmath>

namespace waymark::simulator {
namespace {

void add_cylinders(const std::vector<Cylinder>& cylinders, std::string& out) {
  for (const Cylinder& c : cylinders)
    out += fmt::format("cylinder,{},{},,,{},{}\n", c.center.x(), c.center.y(), c.radius_m, c.height_m);
}

void add_line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double half_width_m, double height_m,
              std::string& out) {
  out += fmt::format("{},{},{},{},{},{},{}\n", half_width_m > 0.0 ? "box" : "wall", from.x(), from.y(), to.x(), to.y(),
                     half_width_m, height_m);
}

}  // namespace

std::string surfaces_csv(const World& world) {
  std::string out = "kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m\n";
  add_cylinders(world.landmarks, out);
  add_cylinders(world.stones, out);
  for (const Box& box : world.boxes) {
    const Eigen::Vector2d along = box.half_m.x() * Eigen::Vector2d(std::cos(box.yaw_rad), std::sin(box.yaw_rad));
    add_line(box.center - along, box.center + along, box.half_m.y(), box.height_m, out);
  }
  for (const Wall& wall : world.walls) add_line(wall.from, wall.to, 0.0, wall.height_m, out);
  if (world.has_ground) out += "level,,,,,,0\n";
  if (world.ceiling_m < World::kNothing) out += fmt::format("level,,,,,,{}\n", world.ceiling_m);
  return out;
}

}  // namespace waymark::simulator
