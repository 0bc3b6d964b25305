// SPDX-License-Identifier: Apache-2.0
#include "world.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace waymark::simulator {
namespace {

constexpr double kWallTile = 2.0;  // [m]
constexpr double kBoxTile = 0.5;   // [m]

/// A horizontal ray; `direction` has length 1.
struct Ray {
  Eigen::Vector2d origin;
  Eigen::Vector2d direction;
};

Ray ray(const Eigen::Vector2d& origin, double angle_rad) {
  return {origin, {std::cos(angle_rad), std::sin(angle_rad)}};
}

/// Where the line of a ray enters and leaves a thing; negative is behind the origin.
struct Crossing {
  double enter;
  double leave;
};

std::optional<Crossing> cross(const Cylinder& cylinder, const Ray& ray) {
  const Eigen::Vector2d to_center = cylinder.center - ray.origin;
  const double along = to_center.dot(ray.direction);
  const double squared_aside = to_center.squaredNorm() - along * along;
  const double squared_half_chord = cylinder.radius_m * cylinder.radius_m - squared_aside;
  if (squared_half_chord < 0.0) return std::nullopt;
  const double half_chord = std::sqrt(squared_half_chord);
  return Crossing{along - half_chord, along + half_chord};
}

/// `v` in the box's own axes.
Eigen::Vector2d in_box(const Box& box, const Eigen::Vector2d& v) {
  const double c = std::cos(box.yaw_rad);
  const double s = std::sin(box.yaw_rad);
  return {c * v.x() + s * v.y(), c * v.y() - s * v.x()};
}

std::optional<Crossing> cross(const Box& box, const Ray& ray) {
  const Eigen::Vector2d origin = in_box(box, ray.origin - box.center);
  const Eigen::Vector2d direction = in_box(box, ray.direction);
  Crossing inside{-World::kNothing, World::kNothing};
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(direction[axis]) < 1e-12) {
      if (std::abs(origin[axis]) > box.half_m[axis]) return std::nullopt;
      continue;
    }
    const double a = (-box.half_m[axis] - origin[axis]) / direction[axis];
    const double b = (box.half_m[axis] - origin[axis]) / direction[axis];
    inside = {std::max(inside.enter, std::min(a, b)), std::min(inside.leave, std::max(a, b))};
  }
  if (inside.enter > inside.leave) return std::nullopt;
  return inside;
}

std::optional<Crossing> cross(const Wall& wall, const Ray& ray) {
  const Eigen::Vector2d span = wall.to - wall.from;
  const double across = ray.direction.x() * span.y() - ray.direction.y() * span.x();
  if (std::abs(across) < 1e-12) return std::nullopt;  // seen edge on
  const Eigen::Vector2d to_wall = wall.from - ray.origin;
  const double share = (to_wall.x() * ray.direction.y() - to_wall.y() * ray.direction.x()) / across;
  if (share < 0.0 || share > 1.0) return std::nullopt;
  const double distance = (to_wall.x() * span.y() - to_wall.y() * span.x()) / across;
  return Crossing{distance, distance};
}

/// Place on the outline and normal where a ray enters.
void describe(const Cylinder& cylinder, const Eigen::Vector2d& p, const Ray&, Hit& hit) {
  hit.outward = (p - cylinder.center) / cylinder.radius_m;
  // Its own place in the tile, so that cylinders of one class are alike but not the same.
  const double shift = 0.37 * cylinder.center.x() + 0.61 * cylinder.center.y();
  hit.tile_u = std::atan2(hit.outward.y(), hit.outward.x()) / (2.0 * std::numbers::pi) + shift;
  hit.tile_m = 2.0 * std::numbers::pi * cylinder.radius_m;
}

void describe(const Box& box, const Eigen::Vector2d& p, const Ray&, Hit& hit) {
  const Eigen::Vector2d local = in_box(box, p - box.center);
  const bool on_end = std::abs(std::abs(local.x()) - box.half_m.x()) < std::abs(std::abs(local.y()) - box.half_m.y());
  const double c = std::cos(box.yaw_rad);
  const double s = std::sin(box.yaw_rad);
  hit.outward = on_end ? Eigen::Vector2d(std::copysign(1.0, local.x()) * Eigen::Vector2d(c, s))
                       : Eigen::Vector2d(std::copysign(1.0, local.y()) * Eigen::Vector2d(-s, c));
  hit.tile_u = (on_end ? local.y() : local.x()) / kBoxTile;
  hit.tile_m = kBoxTile;
}

void describe(const Wall& wall, const Eigen::Vector2d& p, const Ray& ray, Hit& hit) {
  const Eigen::Vector2d along = (wall.to - wall.from).normalized();
  const Eigen::Vector2d normal(-along.y(), along.x());
  hit.outward = normal.dot(ray.direction) < 0.0 ? normal : Eigen::Vector2d(-normal);
  hit.tile_u = (p - wall.from).dot(along) / kWallTile;
  hit.tile_m = kWallTile;
}

template <class Thing>
double nearest_of(const std::vector<Thing>& things, const Ray& ray, double above_m, double nearest) {
  for (const Thing& thing : things) {
    if (thing.height_m <= above_m) continue;
    const auto crossing = cross(thing, ray);
    if (!crossing) continue;
    const double distance = crossing->enter >= 0.0 ? crossing->enter : crossing->leave;
    if (distance >= 0.0) nearest = std::min(nearest, distance);
  }
  return nearest;
}

/// A ray in any direction, with what it is seen from above.
struct Beam {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< of length 1
  double flatness;            ///< length of its horizontal part
  Ray shadow;                 ///< if the beam is vertical, in any direction
};

Beam beam_of(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const double flatness = direction.head<2>().norm();
  const bool is_vertical = flatness < 1e-12;
  const Eigen::Vector2d ahead =
      is_vertical ? Eigen::Vector2d::UnitX() : Eigen::Vector2d(direction.head<2>() / flatness);
  return {origin, direction, is_vertical ? 0.0 : flatness, {origin.head<2>(), ahead}};
}

/// Where along the beam it is neither below a thing nor above it.
std::optional<Crossing> between_heights(const Beam& beam, double base_m, double height_m) {
  const double z = beam.origin.z();
  const double rise = beam.direction.z();
  if (std::abs(rise) < 1e-12) {
    if (z < base_m || z > height_m) return std::nullopt;
    return Crossing{-World::kNothing, World::kNothing};
  }
  const double to_base = (base_m - z) / rise;
  const double to_top = (height_m - z) / rise;
  return Crossing{std::min(to_base, to_top), std::max(to_base, to_top)};
}

/// Where along the beam it is over the outline of a thing.
template <class Thing>
std::optional<Crossing> over_outline(const Thing& thing, const Beam& beam) {
  auto crossing = cross(thing, beam.shadow);
  if (!crossing) return std::nullopt;
  if (beam.flatness > 0.0) return Crossing{crossing->enter / beam.flatness, crossing->leave / beam.flatness};
  if (crossing->enter > 0.0 || crossing->leave < 0.0) return std::nullopt;
  return Crossing{-World::kNothing, World::kNothing};
}

template <class Thing>
double nearest_of(const std::vector<Thing>& things, const Beam& beam, double nearest) {
  for (const Thing& thing : things) {
    const auto outline = over_outline(thing, beam);
    if (!outline || outline->leave < 0.0 || outline->enter >= nearest) continue;
    const auto heights = between_heights(beam, thing.base_m, thing.height_m);
    if (!heights) continue;
    const double enter = std::max(outline->enter, heights->enter);
    const double leave = std::min(outline->leave, heights->leave);
    if (enter > leave || leave < 0.0) continue;
    nearest = std::min(nearest, enter >= 0.0 ? enter : leave);
  }
  return nearest;
}

/// Distance along the beam to a level plane.
double to_level(const Beam& beam, double height_m, double nearest) {
  const double distance = (height_m - beam.origin.z()) / beam.direction.z();
  return distance >= 0.0 ? std::min(nearest, distance) : nearest;  // false for NaN: the beam lies in the plane
}

template <class Thing>
void add_hits(const std::vector<Thing>& things, const Ray& ray, std::vector<Hit>& hits) {
  for (const Thing& thing : things) {
    const auto crossing = cross(thing, ray);
    if (!crossing || crossing->enter <= 0.0) continue;
    Hit hit{crossing->enter, crossing->leave, thing.height_m, thing.texture, 0.0, 1.0, {0.0, 0.0}};
    describe(thing, ray.origin + crossing->enter * ray.direction, ray, hit);
    hits.push_back(hit);
  }
}

}  // namespace

double World::cast(const Eigen::Vector3d& origin, double angle_rad) const {
  const Ray beam = ray(origin.head<2>(), angle_rad);
  double nearest = nearest_of(landmarks, beam, origin.z(), kNothing);
  nearest = nearest_of(stones, beam, origin.z(), nearest);
  nearest = nearest_of(boxes, beam, origin.z(), nearest);
  return nearest_of(walls, beam, origin.z(), nearest);
}

double World::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  const Beam beam = beam_of(origin, direction);
  double nearest = kNothing;
  if (!ground.is_level()) {
    nearest = ground.cast(origin, direction, has_ground, nearest);
  } else if (has_ground) {
    nearest = to_level(beam, 0.0, nearest);
  }
  if (ceiling_m < kNothing) nearest = to_level(beam, ceiling_m, nearest);
  nearest = nearest_of(landmarks, beam, nearest);
  nearest = nearest_of(stones, beam, nearest);
  nearest = nearest_of(boxes, beam, nearest);
  return nearest_of(walls, beam, nearest);
}

void World::trace(const Eigen::Vector2d& origin, double angle_rad, std::vector<Hit>& hits) const {
  hits.clear();
  const Ray line = ray(origin, angle_rad);
  add_hits(landmarks, line, hits);
  add_hits(stones, line, hits);
  add_hits(boxes, line, hits);
  add_hits(walls, line, hits);
  std::ranges::sort(hits, {}, &Hit::enter_m);
}

}  // namespace waymark::simulator
