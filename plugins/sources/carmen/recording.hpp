// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "messages.hpp"
#include "odometry_steps.hpp"
#include "waymark/config/config.hpp"
#include "waymark/io/bad_record_list.hpp"

namespace waymark::carmen {

/// What of a log is wanted, and how its times are read.
struct Wanted {
  enum class Clock { ipc, logger, lines };
  enum class Poses { none, scans, odom, all };
  struct Laser {
    std::string message;            ///< "FLASER"
    std::optional<BeamRule> beams;  ///< of the YAML
  };

  Clock clock = Clock::ipc;
  Duration line_interval{};  ///< of `lines`: from one message to the next
  std::vector<Laser> lasers;
  Poses poses = Poses::none;  ///< whose poses of odometry; those of scans are of the first laser
  bool fixes = false;
};

/// A log, read as a whole: its stamps step back now and then, and what an ODOM message holds of a step may stand behind
/// it.
struct Recording {
  struct Scan {
    Time stamp;
    std::size_t laser = 0;  ///< of `Wanted::lasers`
    std::shared_ptr<LaserScan> scan;
  };
  struct Fix {
    Time stamp;
    std::shared_ptr<GnssFix> fix;
  };
  struct Parameter {
    std::string value;
    std::string place;  ///< "file:line"
  };

  // In order of their stamps, equal ones in that of the log.
  std::vector<Scan> scans;
  std::vector<Fix> fixes;
  std::vector<OdometryPose> poses;
  std::vector<OdometrySpeed> speeds;

  std::map<std::string, Parameter, std::less<>> parameters;     ///< the last of each name
  std::map<std::string, std::size_t, std::less<>> passed_over;  ///< messages that were not wanted, by name
  /// Stamps before that of the message before of the same name, by name.
  std::map<std::string, std::size_t, std::less<>> steps_back;
  Duration longest_step_back{};
  std::exception_ptr failure;  ///< why reading ended before the end of the file
};

/// Reads the log. Lines that cannot be used are bad records; one too many, or a damaged file, ends the reading with
/// `failure`.
Recording read_recording(const std::filesystem::path& file, const Wanted& wanted, BadRecordList& bad);

}  // namespace waymark::carmen
