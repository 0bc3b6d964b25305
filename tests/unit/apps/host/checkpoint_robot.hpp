// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/temporary_folder.hpp"
#include "waymark/config/config.hpp"
#include "waymark/host/fusion.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::test {

/// A small simulated robot whose run was saved in its middle, to load the checkpoint again as it is or damaged. Its
/// checkpoint holds what a checkpoint can hold: `maps` has particles with a feature map, an occupancy grid and an
/// octomap, several sensors with state and late measurements; `rollback` has no maps, but a history and a smoother;
/// `running` is that of a running robot, which holds the measurements that are needed, and those that wait; `loops` has
/// a grid alone, with what loops need; `misplaced` is searched for in a map that was loaded.
class CheckpointRobot {
 public:
  enum class Kind { maps, rollback, running, loops, misplaced };
  explicit CheckpointRobot(Kind kind);

  /// What `Fusion::save` wrote, or `save_with_measurements`.
  const std::string& state() const { return state_; }
  /// The same of another run, with so many threads.
  std::string saved_again(int threads) const;

  /// Resumes a new host from `state`, processes the rest of the log, makes all reports and saves it again. Returns the
  /// message of the DataError that refused it; nothing if the run went on. What else is thrown is a fault of the code
  /// under test.
  std::optional<std::string> load(std::string_view state) const;

  /// A copy of the state with one to three changes, chosen by `number`: bits flipped, numbers overwritten by others
  /// that are likely to do harm, pieces removed, doubled or exchanged, the end cut off.
  std::string damaged(std::uint64_t number) const;

 private:
  Config config(int threads) const;
  std::string state_of(const Fusion& fusion) const;

  Kind kind_;
  TemporaryFolder folder_;  // of the map that is loaded
  PluginLoader loader_;
  std::vector<Measurement> log_;
  std::size_t saved_after_ = 0;  // measurements
  std::string state_;
};

}  // namespace waymark::test
