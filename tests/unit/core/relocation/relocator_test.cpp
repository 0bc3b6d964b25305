// SPDX-License-Identifier: Apache-2.0
#include "relocation/relocator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "loops/planar.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::relocation {
namespace {

using ::testing::HasSubstr;
using Points = std::vector<Eigen::Vector2d>;

constexpr double kCell = 0.1;

void add_wall(Points& points, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const double length = (to - from).norm();
  for (double s = 0.0; s < length; s += 0.5 * kCell) points.emplace_back(from + s / length * (to - from));
}

/// Four walls about (x, y), 6 m × 4 m, and the share of a fifth one in the room, which makes it unlike others.
void add_room(Points& points, double x, double y, double fifth) {
  const Eigen::Vector2d a(x - 3.0, y - 2.0);
  const Eigen::Vector2d b(x + 3.0, y - 2.0);
  const Eigen::Vector2d c(x + 3.0, y + 2.0);
  const Eigen::Vector2d d(x - 3.0, y + 2.0);
  add_wall(points, a, b);
  add_wall(points, b, c);
  add_wall(points, c, d);
  add_wall(points, d, a);
  if (fifth > 0.0) add_wall(points, {x + 1.0, y - 2.0}, {x + 1.0, y - 2.0 + 4.0 * fifth});
}

/// 20 m × 10 m with the points as occupied cells; what lies within `known` of one, along x and y, is free.
GridView map_of(const Points& points, double known = 3.0) {
  GridView map;
  map.T_map_grid.p << -2.0, -5.0, 0.0;
  map.resolution_m = kCell;
  map.width = 260;
  map.height = 100;
  map.cells.assign(26000, GridView::kUnknown);
  const auto cell = [&](double x, double y) -> std::uint8_t& {
    const auto column = static_cast<std::size_t>((x + 2.0) / kCell);
    const auto row = static_cast<std::size_t>((y + 5.0) / kCell);
    return map.cells.at(260 * row + column);
  };
  for (const Eigen::Vector2d& p : points) {
    for (double dy = -known; dy <= known; dy += kCell) {
      const double y = p.y() + dy;
      if (y > -5.0 && y < 5.0) cell(p.x(), y) = 0;
    }
  }
  for (const Eigen::Vector2d& p : points) cell(p.x(), p.y()) = 100;
  return map;
}

/// All points within 5 m, as they look from `pose`.
std::vector<Eigen::Vector2f> seen_from(const Points& points, const Eigen::Vector3d& pose) {
  std::vector<Eigen::Vector2f> seen;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d at = loops::compose(loops::inverse(pose), {p.x(), p.y(), 0.0}).head<2>();
    if (at.norm() < 5.0) seen.emplace_back(at.cast<float>());
  }
  return seen;
}

/// Drives a robot along its x axis in steps of 0.2 m, while the filter follows its wheels.
class Drive {
 public:
  explicit Drive(const GridView& map) : relocator(map) {}
  std::optional<Place> step(const Points& surroundings, bool is_written = false) {
    const Eigen::Vector3d moved(0.2, 0.0, 0.02);
    truth = loops::compose(truth, moved);
    believed = loops::compose(believed, moved);
    const std::vector<Eigen::Vector2f> points = seen_from(surroundings, truth);
    return relocator.add({moved, believed, points, is_written});
  }
  /// The robot is carried; the filter does not know.
  void carry(const Eigen::Vector3d& to) { truth = to; }

  Relocator relocator;
  Eigen::Vector3d truth{0.0, 0.0, 0.1};
  Eigen::Vector3d believed = truth;
};

Points two_rooms() {
  Points points;
  add_room(points, 1.0, 0.0, 0.0);
  add_room(points, 15.0, 0.0, 0.6);
  return points;
}

/// Walls like no others, about (8, 0).
Points hut() {
  Points points;
  add_wall(points, {6.0, -2.0}, {10.0, 3.0});
  add_wall(points, {10.0, 3.0}, {11.0, -3.0});
  add_wall(points, {4.5, 1.0}, {7.0, 4.0});
  return points;
}

void drive_at_home(Drive& drive, const Points& rooms) {
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(drive.step(rooms));
    EXPECT_FALSE(drive.relocator.is_lost());
  }
}

TEST(Relocator, FindsARobotThatWasCarried) {
  const Points rooms = two_rooms();
  Drive drive(map_of(rooms));
  drive_at_home(drive, rooms);
  drive.carry({14.0, 0.5, 2.0});
  std::optional<Place> place;
  for (int i = 0; i < 10 && !place; ++i) place = drive.step(rooms);
  ASSERT_TRUE(place);
  const Eigen::Vector3d off = loops::difference(place->xyyaw, drive.truth);
  EXPECT_LT(off.head<2>().norm(), 0.15);  // cells of 0.1 m
  EXPECT_LT(std::abs(off.z()), 0.02);
  EXPECT_LT(off.dot(place->P.inverse() * off), 16.3);  // χ² of 3 degrees of freedom, 0.1 %
  EXPECT_FALSE(drive.relocator.is_lost());
  EXPECT_LT(std::sqrt(loops::position_variance(place->P)), 0.3);
}

TEST(Relocator, IsLostWhereNothingLooksLikeTheMap) {
  const Points rooms = two_rooms();
  Drive drive(map_of(rooms));
  drive_at_home(drive, rooms);
  drive.truth = {8.0, 0.0, 0.1};
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(drive.step(hut()));
  EXPECT_TRUE(drive.relocator.is_lost());
}

TEST(Relocator, DoesNotChooseBetweenRoomsThatLookAlike) {
  Points rooms;
  add_room(rooms, 1.0, 0.0, 0.6);
  add_room(rooms, 9.0, 0.0, 0.6);
  add_room(rooms, 17.0, 0.0, 0.0);
  Drive drive(map_of(rooms));
  drive.truth = drive.believed = {16.0, 0.0, 0.1};
  Points home;  // nothing is seen through walls
  add_room(home, 17.0, 0.0, 0.0);
  drive_at_home(drive, home);
  Points room;
  add_room(room, 9.0, 0.0, 0.6);
  drive.carry({8.0, 0.0, 0.1});
  for (int i = 0; i < 8; ++i) EXPECT_FALSE(drive.step(room)) << i;
  EXPECT_TRUE(drive.relocator.is_lost());
  EXPECT_EQ(drive.relocator.placement(), Placement::ambiguous);
}

TEST(Relocator, NewGroundIsNoMisfitWhereTheMapIsGoneOnWith) {
  const Points rooms = two_rooms();
  for (const bool is_written : {true, false}) {
    Drive drive(map_of(rooms, 0.5));
    drive_at_home(drive, rooms);
    // Between the rooms the map has nothing: neither a surface nor free ground.
    drive.truth = drive.believed = {8.0, 0.0, 0.1};
    for (int i = 0; i < 8; ++i) drive.step(hut(), is_written);
    EXPECT_EQ(drive.relocator.is_lost(), !is_written);
  }
}

TEST(Relocator, GoesOnFromACheckpoint) {
  const Points rooms = two_rooms();
  Drive drive(map_of(rooms));
  drive_at_home(drive, rooms);
  drive.carry({14.0, 0.5, 2.0});
  drive.step(rooms);
  std::stringstream bytes;
  OutArchive out(bytes);
  drive.relocator.serialize(out);
  Drive resumed(map_of(rooms));
  resumed.truth = drive.truth;
  resumed.believed = drive.believed;
  InArchive in(bytes);
  resumed.relocator.serialize(in);
  for (int i = 0; i < 10; ++i) {
    const auto one = drive.step(rooms);
    const auto other = resumed.step(rooms);
    ASSERT_EQ(one.has_value(), other.has_value());
    EXPECT_EQ(drive.relocator.fit(), resumed.relocator.fit());
    if (!one) continue;
    EXPECT_EQ(one->xyyaw, other->xyyaw);
  }
}

std::string refusal_of(const GridView& map) {
  try {
    Relocator{map};
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(Relocator, RefusesMapsThatCannotBeSearched) {
  GridView map = map_of({});
  EXPECT_THAT(refusal_of(map), HasSubstr("no occupied cells"));
  map.cells.pop_back();
  EXPECT_THAT(refusal_of(map), HasSubstr("without size or place"));
  map.cells.assign(2100, 0);
  map.cells.front() = map.cells.back() = 100;
  map.width = 2100;
  map.height = 1;
  EXPECT_THAT(refusal_of(map), HasSubstr("210 m long"));
  map.resolution_m = 0.4;
  EXPECT_THAT(refusal_of(map), HasSubstr("0.4 m"));
}

TEST(Relocator, BelievesAPoseThatIsSetAndFits) {
  Points rooms;
  add_room(rooms, 1.0, 0.0, 0.6);
  add_room(rooms, 9.0, 0.0, 0.6);
  Drive drive(map_of(rooms));
  Points room;  // nothing is seen through walls
  add_room(room, 1.0, 0.0, 0.6);
  drive_at_home(drive, room);
  Points other;
  add_room(other, 9.0, 0.0, 0.6);
  drive.carry({9.5, 0.5, 2.0});
  for (int i = 0; i < 8; ++i) drive.step(other);
  ASSERT_EQ(drive.relocator.placement(), Placement::ambiguous);
  drive.believed = drive.truth;
  drive.relocator.begin_anew();
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(drive.step(other));
    EXPECT_EQ(drive.relocator.placement(), Placement::fits);
  }
}

}  // namespace
}  // namespace waymark::relocation
