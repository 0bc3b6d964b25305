// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/relations.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kQuarter = 0.5 * std::numbers::pi;

Time at(double seconds) { return Time{from_seconds(seconds)}; }

Trajectory trajectory(std::vector<Trajectory::Point> points, std::string name = "estimate.txt") {
  Trajectory out;
  out.name = std::move(name);
  out.orientation = Orientation::yaw;
  out.points = std::move(points);
  return out;
}

/// At (2, 1) facing north at 1 s, at (2, 4) facing west at 2 s: 3 m ahead and a quarter turn to the left.
Trajectory corner() {
  return trajectory({{at(1.0), Pose::planar(2.0, 1.0, kQuarter)}, {at(2.0), Pose::planar(2.0, 4.0, kHalfTurn)}});
}

template <class Call>
std::string message_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Relations, AMotionThatIsRightHasNoError) {
  const auto score = score_relations({{at(1.0), at(2.0), Pose::planar(3.0, 0.0, kQuarter)}}, corner(), {}, {});
  EXPECT_EQ(score.all.count, 1u);
  EXPECT_NEAR(score.all.translation_m.mean, 0.0, 1e-12);
  EXPECT_NEAR(score.all.rotation_rad.mean, 0.0, 1e-7);
  EXPECT_EQ(score.poses_at_row, 2u);
  EXPECT_EQ(score.far_apart.count, 0u);
}

// The relation's inverse times the motion: off by (0.3, 0.4) m and by 0.1 rad; and by 1.5 m and 0.3 rad.
TEST(Relations, MeanDeviationMaximumAndSquares) {
  const std::vector<Relation> relations{{at(1.0), at(2.0), Pose::planar(2.7, -0.4, kQuarter + 0.1)},
                                        {at(2.0), at(1.0), Pose::planar(0.0, 4.5, -kQuarter - 0.3)}};
  const auto score = score_relations(relations, corner(), {}, {});
  EXPECT_EQ(score.all.count, 2u);
  EXPECT_NEAR(score.all.translation_m.mean, 1.0, 1e-12);
  EXPECT_NEAR(score.all.translation_m.deviation, 0.5, 1e-12);
  EXPECT_NEAR(score.all.translation_m.max, 1.5, 1e-12);
  EXPECT_NEAR(score.all.translation_squared_m2.mean, 1.25, 1e-12);
  EXPECT_NEAR(score.all.translation_squared_m2.deviation, 1.0, 1e-12);
  EXPECT_NEAR(score.all.rotation_rad.mean, 0.2, 1e-9);
  EXPECT_NEAR(score.all.rotation_rad.deviation, 0.1, 1e-9);
  EXPECT_NEAR(score.all.rotation_squared_rad2.mean, 0.05, 1e-9);
}

TEST(Relations, OfASensorAheadOfTheBase) {
  // 0.5 m ahead: from (2, 1.5) facing north to (1.5, 4) facing west.
  RelationOptions options;
  options.T_base_sensor = Pose::planar(0.5, 0.0, 0.0);
  const auto score = score_relations({{at(1.0), at(2.0), Pose::planar(2.5, 0.5, kQuarter)}}, corner(), {}, options);
  EXPECT_NEAR(score.all.translation_m.mean, 0.0, 1e-12);
}

TEST(Relations, OverMoreThanAMinuteAlsoCountByThemselves) {
  const auto line = trajectory({{at(0.0), Pose::planar(0.0, 0.0, 0.1)},
                                {at(60.0), Pose::planar(1.0, 0.0, 0.1)},
                                {at(60.5), Pose::planar(1.0, 0.0, 0.1)}});
  const Pose none;
  const auto score = score_relations({{at(0.0), at(60.0), none}, {at(60.5), at(0.0), none}}, line, {}, {});
  EXPECT_EQ(score.all.count, 2u);
  EXPECT_EQ(score.far_apart.count, 1u);
  EXPECT_NEAR(score.far_apart.translation_m.mean, 1.0, 1e-12);
}

TEST(Relations, StampsAgreeToAMicrosecond) {
  auto estimate = corner();
  estimate.points[1].stamp += std::chrono::nanoseconds(900);
  const std::vector<Relation> relations{{at(1.0), at(2.0), Pose::planar(3.0, 0.0, kQuarter)}};
  EXPECT_EQ(score_relations(relations, estimate, {}, {}).poses_at_row, 2u);
  estimate.points[1].stamp -= std::chrono::microseconds(2);
  EXPECT_THAT(message_of([&] { score_relations(relations, estimate, {}, {}); }), HasSubstr("none of 1 is covered"))
      << "behind the last row";
}

TEST(Relations, BetweenRowsItIsInterpolatedOverShortPausesOnly) {
  const std::vector<Relation> relations{{at(1.0), at(1.5), Pose::planar(1.5, 0.0, 0.25 * std::numbers::pi)},
                                        {at(1.0), at(2.0), Pose::planar(3.0, 0.0, kQuarter)}};
  const auto score = score_relations(relations, corner(), {}, {});
  EXPECT_EQ(score.all.count, 2u);
  EXPECT_EQ(score.poses_at_row, 3u);
  EXPECT_NEAR(score.all.translation_m.max, 0.0, 1e-12);
  EXPECT_NEAR(score.all.rotation_rad.max, 0.0, 1e-7);
  RelationOptions options;
  options.max_time_gap_s = 0.9;
  const auto strict = score_relations(relations, corner(), {}, options);
  EXPECT_EQ(strict.all.count, 1u);
  EXPECT_EQ(strict.uncovered, 1u);
}

/// Dead reckoning in a frame of its own: rests until 20 s, then goes 2 m ahead in two seconds, 1 s of it per metre.
Trajectory reckoning() {
  std::vector<Trajectory::Point> points;
  for (int k = 0; k <= 230; ++k) {
    const double t = 0.1 * k;
    points.push_back({at(t), Pose::planar(7.0, -3.0 + std::min(std::max(t - 20.0, 0.0), 2.0), kQuarter)});
  }
  return trajectory(std::move(points), "reckoning.txt");
}

// Rows at 0 s and 22 s; dead reckoning went 2 m between them, the estimate 2.2 m. Half way, at 21 s, the row
// before plus 1 m is 1 m, the row after less 1 m is 1.2 m.
TEST(Relations, AMotionFillsPausesFromBothSidesByTheShareOfTheWay) {
  const auto estimate = trajectory({{at(0.0), Pose::planar(0.0, 0.0, 0.0)}, {at(22.0), Pose::planar(2.2, 0.0, 1e-9)}});
  const auto x_at = [&](double t) {
    const auto score = score_relations({{at(0.0), at(t), Pose{}}}, estimate, reckoning(), {});
    return score.all.translation_m.mean;
  };
  EXPECT_NEAR(x_at(10.0), 0.0, 1e-9) << "it rests: the whole correction lies on the way";
  EXPECT_NEAR(x_at(21.0), 1.1, 1e-6);
  EXPECT_NEAR(x_at(21.55), 1.705, 1e-6) << "also between two rows of the motion";
  EXPECT_NEAR(x_at(22.5), 2.2, 1e-6) << "and beyond the last row";
  EXPECT_THAT(message_of([&] {
                RelationOptions options;
                options.max_time_gap_s = 0.4;
                score_relations({{at(0.0), at(22.5), Pose{}}}, estimate, reckoning(), options);
              }),
              HasSubstr("none of 1 is covered by estimate.txt"));
}

TEST(Relations, AnEstimateWithoutOrientationIsAnError) {
  auto estimate = corner();
  estimate.orientation = Orientation::none;
  EXPECT_THAT(message_of([&] {
                score_relations({{at(1.0), at(2.0), Pose{}}}, estimate, {}, {});
              }),
              HasSubstr("estimate.txt has no orientation"));
}

class RelationFile : public ::testing::Test {
 protected:
  std::filesystem::path write(std::string_view content) {
    std::filesystem::path file = folder_ / "some.relations";
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
  test::TemporaryFolder folder_;
};

TEST_F(RelationFile, IsReadToTheNanosecond) {
  const auto relations = read_relations(write(
      "# t1 t2 …\n976052890.246828 976052893.182585 0.9 -0.2 0.1 0 0 0.5\n976052890.246828 2 1 2 3 0.1 0.2 0.3\n"));
  ASSERT_EQ(relations.size(), 2u);
  EXPECT_EQ(relations[0].from, parse_time("976052890.246828"));
  EXPECT_EQ(relations[0].to, parse_time("976052893.182585"));
  EXPECT_EQ(relations[0].T_from_to.p, Eigen::Vector3d(0.9, -0.2, 0.1));
  EXPECT_NEAR(relations[0].T_from_to.yaw(), 0.5, 1e-12);
  EXPECT_TRUE(relations[1].T_from_to.q.isApprox(so3::from_rpy(0.1, 0.2, 0.3)));
}

TEST_F(RelationFile, ALineThatIsNoneIsNamed) {
  const std::string good = "1 2 0 0 0 0 0 0\n";
  const auto error = [&](const std::string& line) { return message_of([&] { read_relations(write(good + line)); }); };
  EXPECT_THAT(error("1 2 0 0 0 0 0\n"), AllOf(HasSubstr(":2"), HasSubstr("7 fields, expected at least 8")));
  EXPECT_THAT(error("1 2 0 zero 0 0 0 0\n"), AllOf(HasSubstr(":2"), HasSubstr("zero")));
  EXPECT_THAT(error("1 soon 0 0 0 0 0 0\n"), AllOf(HasSubstr(":2"), HasSubstr("soon")));
  EXPECT_THAT(error("666666666666661.5 2 0 0 0 0 0 0\n"), AllOf(HasSubstr(":2: t1"), HasSubstr("666666666666661.5")));
  EXPECT_THAT(message_of([&] { read_relations("/nowhere.relations"); }), HasSubstr("/nowhere.relations"));
}

}  // namespace
}  // namespace waymark::evaluation
