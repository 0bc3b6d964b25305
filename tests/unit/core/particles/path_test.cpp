// SPDX-License-Identifier: Apache-2.0
#include "particles/path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <sstream>
#include <vector>

#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

using ::testing::ElementsAre;

void extend(particles::Path& path, int from, int to) {
  for (int i = from; i < to; ++i) path.append(test::at(i), Pose::planar(i, -i, 0.001 * i));
}

std::string saved(const std::vector<particles::Path>& paths) {
  std::ostringstream stream;
  OutArchive out(stream);
  for (const particles::Path& path : paths) out(path);
  return stream.str();
}

TEST(Path, StartsEmpty) {
  const particles::Path path;
  EXPECT_TRUE(path.empty());
  EXPECT_TRUE(path.poses().empty());
}

TEST(Path, ListsThePosesFromTheRootToTheLeaf) {
  particles::Path path;
  extend(path, 0, 4);
  const auto poses = path.poses();
  ASSERT_EQ(poses.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(poses[static_cast<std::size_t>(i)].stamp, test::at(i));
    EXPECT_EQ(poses[static_cast<std::size_t>(i)].T_map_base.p, Eigen::Vector3d(i, -i, 0.0));
  }
}

TEST(Path, CopiesShareTheTrunkAndGrowApart) {
  particles::Path a;
  extend(a, 0, 3);
  particles::Path b = a;
  extend(a, 10, 12);
  extend(b, 20, 21);
  ASSERT_EQ(a.poses().size(), 5U);
  ASSERT_EQ(b.poses().size(), 4U);
  EXPECT_EQ(a.poses()[2].stamp, b.poses()[2].stamp);
  EXPECT_EQ(a.poses()[3].stamp, test::at(10));
  EXPECT_EQ(b.poses()[3].stamp, test::at(20));
}

TEST(Path, ABranchSurvivesTheOther) {
  particles::Path kept;
  {
    particles::Path dropped;
    extend(dropped, 0, 5);
    kept = dropped;
    extend(dropped, 5, 9);
  }
  EXPECT_EQ(kept.poses().size(), 5U);
}

TEST(Path, AssignmentToItselfChangesNothing) {
  particles::Path path;
  extend(path, 0, 3);
  const particles::Path& same = path;
  path = same;
  EXPECT_EQ(path.poses().size(), 3U);
}

constexpr int kLong = 1'000'000;

TEST(Path, AMillionPosesAreFreedWithoutRecursion) {
  auto path = std::make_unique<particles::Path>();
  extend(*path, 0, kLong);
  const particles::Path copy = *path;
  path.reset();
  EXPECT_EQ(copy.poses().size(), static_cast<std::size_t>(kLong));
}

TEST(Path, AMillionPosesAreFreedWithoutRecursionWhenAssignedOver) {
  particles::Path path;
  extend(path, 0, kLong);
  path = particles::Path();
  EXPECT_TRUE(path.empty());
}

TEST(Path, LoadingGivesBackTheSamePoses) {
  particles::Path path;
  extend(path, 0, 6);
  std::istringstream stream(saved({path}));
  InArchive in(stream);
  particles::Path loaded;
  extend(loaded, 0, 2);
  in(loaded);
  const auto expected = path.poses();
  const auto actual = loaded.poses();
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].stamp, expected[i].stamp);
    EXPECT_EQ(actual[i].T_map_base.p, expected[i].T_map_base.p);
    EXPECT_EQ(actual[i].T_map_base.q.coeffs(), expected[i].T_map_base.q.coeffs());
  }
}

TEST(Path, TheSharedTrunkIsSavedOnceAndSharedAgain) {
  particles::Path trunk;
  extend(trunk, 0, 1000);
  std::vector<particles::Path> paths(5, trunk);
  for (int i = 0; i < 5; ++i) extend(paths[static_cast<std::size_t>(i)], 2000 + i, 2001 + i);
  const std::string bytes = saved(paths);
  EXPECT_LT(bytes.size(), saved({trunk}).size() + 5 * 200);

  std::istringstream stream(bytes);
  InArchive in(stream);
  std::vector<particles::Path> loaded(5);
  for (particles::Path& path : loaded) in(path);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(loaded[static_cast<std::size_t>(i)].poses().size(), 1001U);
    EXPECT_EQ(loaded[static_cast<std::size_t>(i)].poses().back().stamp, test::at(2000 + i));
  }
  // Sharing is what makes the second saving as small as the first.
  EXPECT_EQ(saved(loaded), bytes);
}

TEST(Path, ALoadedMillionPosesOutlivedByTheArchiveAreFreedWithoutRecursion) {
  particles::Path path;
  extend(path, 0, kLong);
  std::istringstream stream(saved({path}));
  InArchive in(stream);
  particles::Path loaded;
  in(loaded);
  EXPECT_EQ(loaded.poses().size(), static_cast<std::size_t>(kLong));
  loaded = particles::Path();
}

std::vector<int> seconds(const particles::Path& path) {
  std::vector<int> all;
  for (const StampedPose& pose : path.poses())
    all.push_back(static_cast<int>(to_seconds(pose.stamp - test::at(0)) + 0.5));
  return all;
}

TEST(Path, ThinningRemovesEverySecondPoseOfTheBeginning) {
  particles::Path path;
  extend(path, 0, 5);
  for (int i = 5; i < 8; ++i) path.append_tentative(test::at(i), Pose::planar(i, -i, 0.0));
  particles::Path* const one = &path;
  particles::Path::thin(std::span(&one, 1), 7);
  EXPECT_THAT(seconds(path), ElementsAre(0, 2, 4, 6, 7));
  EXPECT_EQ(path.size(), 5U);
  particles::Path::thin(std::span(&one, 1), 3);
  EXPECT_THAT(seconds(path), ElementsAre(0, 4, 6, 7));
}

TEST(Path, ThinnedPathsShareTheirTrunkAsBefore) {
  particles::Path trunk;
  extend(trunk, 0, 1000);
  std::vector<particles::Path> paths(5, trunk);
  std::vector<particles::Path*> all;
  for (int i = 0; i < 5; ++i) {
    particles::Path& path = paths[static_cast<std::size_t>(i)];
    extend(path, 2000 + i, 2003 + i);
    all.push_back(&path);
  }
  particles::Path::thin(all, 500);
  for (int i = 0; i < 5; ++i) {
    const std::vector<int> left = seconds(paths[static_cast<std::size_t>(i)]);
    ASSERT_EQ(left.size(), 753U);
    EXPECT_EQ(left.size(), paths[static_cast<std::size_t>(i)].size());
    EXPECT_EQ(left[1], 2);
    EXPECT_EQ(left.back(), 2002 + i);
  }
  EXPECT_LT(saved(paths).size(), saved({paths[0]}).size() + 5 * 600);
  EXPECT_EQ(trunk.poses().size(), 1000U) << "of others";
}

TEST(Path, ALoadedPathIsThinnedAsTheOneThatWasSaved) {
  particles::Path path;
  extend(path, 0, 100);
  std::istringstream stream(saved({path}));
  InArchive in(stream);
  particles::Path loaded;
  in(loaded);
  for (particles::Path* each : {&path, &loaded}) particles::Path::thin(std::span(&each, 1), 51);
  EXPECT_EQ(seconds(loaded), seconds(path));
}

// --- a robot that stands ---------------------------------------------------------------------------------------------

constexpr double kRate = 5.0;             // poses a second
constexpr int kTenMinutes = 600 * 5 + 1;  // poses
constexpr int kHour = 3600 * 5;
constexpr int kDay = 24 * kHour;

Pose trembling(int i) { return Pose::planar(3.0 + 0.01 * (i % 3), 4.0, 0.01 * (i % 2)); }

/// Poses `from` to `to` − 1 of a robot that stands; `Append` is append or append_tentative.
template <class Append>
void stand(particles::Path& path, int from, int to, Append append) {
  for (int i = from; i < to; ++i) (path.*append)(test::at(i / kRate), trembling(i));
}

TEST(Path, KeepsEveryPoseOfTenMinutesInOnePlace) {
  particles::Path path;
  stand(path, 0, kTenMinutes, &particles::Path::append);
  EXPECT_EQ(path.poses().size(), static_cast<std::size_t>(kTenMinutes));
}

class StandingPath : public testing::TestWithParam<void (particles::Path::*)(Time, const Pose&)> {};

TEST_P(StandingPath, TakesNoMoreMemoryAfterADayThanAfterAnHour) {
  particles::Path path;
  stand(path, 0, kHour, GetParam());
  const std::size_t after_an_hour = path.poses().size();
  stand(path, kHour, kDay / 2, GetParam());
  const std::size_t after_half_a_day = path.poses().size();
  stand(path, kDay / 2, kDay, GetParam());
  EXPECT_LT(after_an_hour, kTenMinutes + 250U);
  EXPECT_LT(after_half_a_day, after_an_hour + 260U);
  EXPECT_LT(path.poses().size(), after_half_a_day + 75U);
}

TEST_P(StandingPath, EndsWithTheNewestPose) {
  particles::Path path;
  for (int i = 0; i < kHour; ++i) {
    (path.*GetParam())(test::at(i / kRate), trembling(i));
    if (i % 1000 != 0) continue;
    const StampedPose last = path.poses().back();
    EXPECT_EQ(last.stamp, test::at(i / kRate));
    EXPECT_EQ(last.T_map_base.p, trembling(i).p);
  }
}

TEST_P(StandingPath, KeepsEveryPoseOnceTheRobotHasMoved) {
  particles::Path path;
  stand(path, 0, kDay, GetParam());
  const std::size_t standing = path.poses().size();
  for (int i = 1; i <= 1000; ++i) (path.*GetParam())(test::at((kDay + i) / kRate), Pose::planar(3.0 + i, 4.0, 0.0));
  EXPECT_EQ(path.poses().size(), standing + 1000U);
}

TEST_P(StandingPath, IsTheSameIfItIsSavedAndLoadedInBetween) {
  particles::Path path;
  stand(path, 0, kHour, GetParam());
  std::istringstream stream(saved({path}));
  InArchive in(stream);
  particles::Path loaded;
  in(loaded);
  for (particles::Path* each : {&path, &loaded}) stand(*each, kHour, 3 * kHour, GetParam());
  EXPECT_EQ(saved({loaded}), saved({path}));
}

INSTANTIATE_TEST_SUITE_P(OfMappingSteps, StandingPath, testing::Values(&particles::Path::append));
INSTANTIATE_TEST_SUITE_P(OfDeadReckoning, StandingPath, testing::Values(&particles::Path::append_tentative));

TEST(Path, ACopyKeepsItsPosesWhileTheOtherStands) {
  particles::Path path;
  stand(path, 0, kHour, &particles::Path::append);
  const particles::Path copy = path;
  const std::string before = saved({copy});
  stand(path, kHour, 2 * kHour, &particles::Path::append);
  EXPECT_EQ(saved({copy}), before);
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(Path, RefusesAPoseThatDescendsFromItself) {
  // The leaf has the number 0 behind "more", its parent the number 1; a third item is announced, which is the leaf.
  std::ostringstream damaged;
  OutArchive out(damaged);
  out.section("path", 3);
  for (const std::uint64_t number : {0U, 1U}) {
    out(true, number, test::at(0), Eigen::Vector3d(1.0, 2.0, 0.0), Eigen::Quaterniond::Identity());
  }
  out(true, std::uint64_t{0});
  std::istringstream stream(damaged.str());
  InArchive in(stream);
  particles::Path loaded;
  EXPECT_THROW(in(loaded), DataError);
}

TEST(Path, SpreadsTheErrorOfDeadReckoningOverIt) {
  particles::Path path;
  path.append(Time{Duration{0}}, Pose::planar(0.0, 0.0, 0.0));
  path.append_tentative(Time{Duration{1}}, Pose::planar(1.0, 0.0, 0.0));
  path.append_tentative(Time{Duration{2}}, Pose::planar(1.0, 0.0, 0.0));  // it stood
  path.append_tentative(Time{Duration{3}}, Pose::planar(3.0, 0.0, 0.0));
  EXPECT_EQ(path.poses().size(), 4U);
  path.distribute_correction(Pose::planar(4.0, 0.0, 0.0), Pose::planar(4.0, 0.4, 0.0));
  path.append(Time{Duration{4}}, Pose::planar(4.0, 0.4, 0.0));
  const std::vector<StampedPose> poses = path.poses();
  ASSERT_EQ(poses.size(), 5U);
  EXPECT_NEAR(poses[1].T_map_base.p.y(), 0.1, 1e-12);
  EXPECT_NEAR(poses[2].T_map_base.p.y(), 0.1, 1e-12);
  EXPECT_NEAR(poses[3].T_map_base.p.y(), 0.3, 1e-12);
  EXPECT_NEAR(poses[3].T_map_base.p.x(), 3.0, 1e-12);
}

TEST(Path, TurnsWhatLiesBehindAnErrorOfHeading) {
  particles::Path path;
  path.append(Time{Duration{0}}, Pose::planar(0.0, 0.0, 0.0));
  path.append_tentative(Time{Duration{1}}, Pose::planar(1.0, 0.0, 0.0));
  path.distribute_correction(Pose::planar(2.0, 0.0, 0.0), Pose::planar(2.0, 0.0, 0.02));
  const StampedPose middle = path.poses()[1];
  EXPECT_NEAR(middle.T_map_base.yaw(), 0.01, 1e-9);
  // Seen from the end it would lie 0.02 to the right, seen from the beginning straight ahead.
  EXPECT_NEAR(middle.T_map_base.p.y(), -0.01, 1e-5);
}

TEST(Path, KeepsDeadReckoningInAnArchive) {
  particles::Path path;
  path.append(Time{Duration{0}}, Pose::planar(0.0, 0.0, 0.0));
  path.append_tentative(Time{Duration{1}}, Pose::planar(1.0, 0.0, 0.1));
  std::stringstream stream;
  OutArchive out(stream);
  out(path);
  InArchive in(stream);
  particles::Path again;
  in(again);
  again.distribute_correction(Pose::planar(1.0, 0.0, 0.1), Pose::planar(1.0, 0.2, 0.1));
  ASSERT_EQ(again.poses().size(), 2U);
  EXPECT_NEAR(again.poses()[1].T_map_base.p.y(), 0.2, 1e-12);
}

}  // namespace
}  // namespace waymark
