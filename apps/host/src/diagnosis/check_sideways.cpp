// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstddef>

#include "checks.hpp"
#include "path_fit.hpp"

namespace waymark::host::diagnosis {

void check_sideways(Case& c, const MotionAgreement& motion) {
  const Observer* turns = motion.yaw.trusted_track();
  const Observer* along = motion.way.trusted_track();
  if (turns == nullptr || along == nullptr || c.is_concerned(turns->sensor) || c.is_concerned(along->sensor)) return;
  const Way way = way_of(c, *along);
  if (way.left == nullptr) return;
  const WatchedSensor& sensor = c.sensor(along->sensor);
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& receiver = c.sensor(i);
    if (receiver.fixes.empty() || c.is_concerned(i) || i == along->sensor || i == turns->sensor) continue;
    const PathFit as_given(receiver, *turns->track, way);
    const PathFit opposite(receiver, *turns->track, Way(way.forwards, way.left, -1.0));
    if (!as_given.is_known()) continue;
    const PathFit::Gain gain = opposite.gain_over(as_given);
    if (!gain.is_clear()) continue;
    c.add(Finding::Certainty::named, "direction", {along->sensor},
          fmt::format("the path of {} fits with the opposite sign of its way to the left", receiver.name),
          fmt::format("source: the sign of the speed of {} to the left, which is positive", sensor.name), gain.sigmas);
    return;
  }
}

}  // namespace waymark::host::diagnosis
