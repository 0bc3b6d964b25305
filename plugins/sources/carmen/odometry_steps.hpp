// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "messages.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/bad_record_list.hpp"

namespace waymark::carmen {

/// Where odometry had the robot.
struct OdometryPose {
  Time stamp;
  PlanarPose T_odom_base;
  std::string place;  ///< "file:line"
};

/// The speed that an ODOM message gives, apart from its pose.
struct OdometrySpeed {
  Time stamp;
  double tv_mps = 0.0;
};

/// The motion from one pose of odometry to the next.
struct OdometryStep {
  Time begin;
  Time end;
  std::shared_ptr<PoseIncrement> increment;
};

/// What was made of the poses.
struct OdometrySteps {
  std::vector<OdometryStep> steps;
  std::size_t turned = 0;      ///< steps whose direction was turned round
  std::size_t stretches = 0;   ///< runs of such steps
  double turned_m = 0.0;       ///< their length in all
  std::exception_ptr failure;  ///< a bad record too many, after these steps
};

struct StepOptions {
  bool repair_reversals = true;
  double max_speed_mps = 20.0;
};

/// The steps between poses in order of their stamps; of equal stamps the last pose counts, and no motion is lost. A
/// base that counts its wheels' turns without a sign moves forward in odometry while it reverses: where the speed
/// nearest to the middle of a step is backward and the step goes forward, its translation is turned round. A step
/// faster than `max_speed_mps` (an interval counts as 0.1 s at least) is none (odometry was set anew): it is left out
/// as a bad record; one too many ends the steps.
OdometrySteps make_steps(const std::vector<OdometryPose>& poses, const std::vector<OdometrySpeed>& speeds,
                         const StepOptions& options, BadRecordList& bad);

}  // namespace waymark::carmen
