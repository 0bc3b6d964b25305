// SPDX-License-Identifier: Apache-2.0
// Checkpoints behind their checksum. A checkpoint of a real run is large, so an input is a list of changes of one: the
// first byte selects the robot, and every 13 bytes are one change.
#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/unit/apps/host/checkpoint_robot.hpp"

namespace waymark::fuzz::checkpoint_harness {
namespace {

using test::CheckpointRobot;

/// As it lies in an input.
struct Change {
  static constexpr std::size_t kSize = 13;
  std::uint8_t kind = 0;
  std::uint32_t place = 0;
  std::uint64_t number = 0;
};

Change read_change(std::string_view bytes) {
  Change change;
  std::memcpy(&change.kind, bytes.data(), sizeof change.kind);
  std::memcpy(&change.place, bytes.data() + 1, sizeof change.place);
  std::memcpy(&change.number, bytes.data() + 5, sizeof change.number);
  return change;
}

void make(const Change& change, std::string& state) {
  const std::size_t at = change.place % (state.size() + 1);
  const auto overwrite = [&](std::size_t size) {
    std::memcpy(state.data() + at, &change.number, std::min(size, state.size() - at));
  };
  const std::size_t few = 1 + (change.number >> 32) % 64;
  const std::string piece = state.substr(change.number % (state.size() + 1), few);
  switch (change.kind % 7) {
    case 0:
      return overwrite(1);
    case 1:
      return overwrite(4);
    case 2:
      return overwrite(8);
    case 3:
      state.replace(at, piece.size(), piece);
      return;
    case 4:
      state.insert(at, piece);
      return;
    case 5:
      state.erase(at, few);
      return;
    default:
      state.resize(at);
  }
}

void run(std::string_view input) {
  constexpr std::size_t kMostChanges = 8;
  static const std::array<CheckpointRobot, 5> kRobots{
      CheckpointRobot(CheckpointRobot::Kind::rollback), CheckpointRobot(CheckpointRobot::Kind::running),
      CheckpointRobot(CheckpointRobot::Kind::maps), CheckpointRobot(CheckpointRobot::Kind::loops),
      CheckpointRobot(CheckpointRobot::Kind::misplaced)};
  const Choice choice = choose(input, kRobots.size());
  std::string_view rest = choice.rest.substr(0, kMostChanges * Change::kSize);
  const CheckpointRobot& robot = kRobots[choice.which];
  std::string state = robot.state();
  for (; rest.size() >= Change::kSize; rest.remove_prefix(Change::kSize)) make(read_change(rest), state);
  (void)robot.load(state);
}

const Harness kHarness("checkpoint", run);

}  // namespace
}  // namespace waymark::fuzz::checkpoint_harness
