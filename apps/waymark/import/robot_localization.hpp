// SPDX-License-Identifier: Apache-2.0
// From the parameters of other programs to a robot's YAML.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace waymark::imports {

struct ImportSettings {
  std::string node = {};                 ///< of the file, which one; empty: the only one, or the one in the map's frame
  std::filesystem::path recording = {};  ///< .bag, .mcap or a folder of rosbag2; empty: topics of a running robot
  std::string fix_topic = "/fix";        ///< of the GPS receiver, if there is a `navsat_transform` before the filter
};

struct Imported {
  std::string yaml;                ///< the robot, with comments
  std::vector<std::string> notes;  ///< what could not be taken over, and what should be looked at; also in the YAML
};

/// A robot from the parameters of `ekf_node` or `ukf_node` of robot_localization (T. Moore, D. Stouch, 2014), in the
/// form of ROS 1 or ROS 2. Throws DataError with file and line if the file cannot be read, holds no such node, several
/// of which none is chosen, or a value of the wrong form; and if no input measures how the robot moves.
Imported import_robot_localization(const std::filesystem::path& file, const ImportSettings& settings);

}  // namespace waymark::imports
