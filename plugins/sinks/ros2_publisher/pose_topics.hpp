// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "plugins/shared/dds/writer.hpp"
#include "pose_messages.hpp"
#include "smooth_odometry.hpp"
#include "topic_names.hpp"

namespace waymark::ros2_publisher {

/// What follows every pose: two kinds of odometry, /tf, the pose, the fix. Written by the calling thread, which never
/// waits for a reader.
class PoseTopics {
 public:
  /// Throws Error. `datum`: only needed for the fix.
  PoseTopics(const dds::Participant& participant, const Topics& topics, Frames frames, Duration ahead,
             std::optional<Datum> datum);

  /// A pose that is not later than the last one is left out: /tf takes a stamp once.
  void publish(const Belief& belief, const StateIndices& indices);
  /// Messages that were left out since a reader was slow.
  std::uint64_t left_out() const;

 private:
  Frames frames_;
  Duration ahead_;
  std::optional<Datum> datum_;
  std::unique_ptr<dds::Writer> odometry_, odometry_in_map_, tf_, pose_, fix_;  // null: not wanted
  SmoothOdometry smooth_;
  std::optional<Time> last_;
};

}  // namespace waymark::ros2_publisher
