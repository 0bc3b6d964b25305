// SPDX-License-Identifier: Apache-2.0
// needs plugins: simulator, odometry, dgps, imu, compass, feature_map, occupancy_grid, octomap_grid
// Checkpoints of whole robots: equal runs give equal bytes, and what is damaged is refused or does no harm.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <string>

#include "unit/apps/host/checkpoint_robot.hpp"

namespace waymark {
namespace {

using test::CheckpointRobot;

class Checkpoint : public testing::TestWithParam<CheckpointRobot::Kind> {
 protected:
  CheckpointRobot robot_{GetParam()};
};

TEST_P(Checkpoint, OfEqualRunsHasEqualBytes) {
  EXPECT_EQ(robot_.saved_again(1), robot_.state());
  EXPECT_EQ(robot_.saved_again(3), robot_.state());
  EXPECT_EQ(CheckpointRobot(GetParam()).state(), robot_.state());
}

TEST_P(Checkpoint, IsLoadedAndTheRunGoesOn) { EXPECT_EQ(robot_.load(robot_.state()), std::nullopt); }

TEST_P(Checkpoint, ThatIsCutOffIsRefused) {
  const std::string& state = robot_.state();
  for (std::size_t size = 0; size < state.size(); size += 1 + state.size() / 50)
    EXPECT_TRUE(robot_.load(state.substr(0, size)).has_value()) << size << " bytes";
}

/// More of them: WAYMARK_DAMAGED_CHECKPOINTS=10000.
TEST_P(Checkpoint, ThatIsDamagedIsRefusedOrDoesNoHarm) {
  const char* const given = std::getenv("WAYMARK_DAMAGED_CHECKPOINTS");  // NOLINT(concurrency-mt-unsafe)
  const int count = given != nullptr ? std::atoi(given) : 150;
  int refused = 0;
  for (int number = 0; number < count; ++number) {
    SCOPED_TRACE(number);
    ASSERT_NO_THROW(refused += robot_.load(robot_.damaged(static_cast<std::uint64_t>(number))).has_value());
  }
  EXPECT_GT(refused, count / 4);
}

std::string name_of(const testing::TestParamInfo<CheckpointRobot::Kind>& kind) {
  constexpr std::array<const char*, 5> kNames{"WithMaps", "WithRollback", "ThatRuns", "WithLoops", "Misplaced"};
  return kNames.at(static_cast<std::size_t>(kind.param));
}

INSTANTIATE_TEST_SUITE_P(OfARobot, Checkpoint,
                         testing::Values(CheckpointRobot::Kind::maps, CheckpointRobot::Kind::rollback,
                                         CheckpointRobot::Kind::running, CheckpointRobot::Kind::loops,
                                         CheckpointRobot::Kind::misplaced),
                         name_of);

}  // namespace
}  // namespace waymark
