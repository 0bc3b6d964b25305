// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "particles/stay.hpp"
#include "waymark/base/api.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/memory/lineage.hpp"

namespace waymark::particles {

/// A particle's path; particles share the parts of common ancestors. Between two mapping steps it is dead reckoning;
/// the correction of the next step is distributed over it. Of a robot that stands for longer than ten minutes not every
/// pose is kept (`Stay`).
class WAYMARK_API Path {
 public:
  /// Appends a pose of a mapping step.
  void append(Time stamp, const Pose& T_map_base);
  /// A pose of dead reckoning since the last `append`.
  void append_tentative(Time stamp, const Pose& T_map_base);
  /// Corrects the poses of dead reckoning, which predicted `predicted` where the mapping step found `found`. Each gets
  /// a share of the correction: its share of the motion since the last `append`. Then they are no longer tentative.
  void distribute_correction(const Pose& predicted, const Pose& found);
  /// Sets the poses, in order; none of them is tentative.
  void replace(std::span<const StampedPose> poses);
  /// All poses, in order.
  std::vector<StampedPose> poses() const;
  /// The poses from the last one that both paths share and that is not tentative; all if they share none.
  std::vector<StampedPose> poses_since(const Path& known) const;
  bool empty() const { return poses_.empty() && tentative_.empty(); }
  /// Number of poses.
  std::size_t size() const { return poses_.size() + tentative_.size(); }
  /// Removes every second one of the first `count` poses of each path, fewer than any of them has. What paths share
  /// stays shared.
  static void thin(std::span<Path* const> paths, std::size_t count);

  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("path", 3) < 3) throw DataError("the checkpoint has an older version");
    poses_.serialize(archive, kFieldsOfPose);
    archive.each(tentative_, kFieldsOfPose);
    archive(stay_);
  }

 private:
  static constexpr auto kFieldsOfPose = [](auto& archive, StampedPose& pose) {
    archive(pose.stamp, pose.T_map_base.p, pose.T_map_base.q);
  };

  void drop_last();

  Lineage<StampedPose> poses_;
  std::vector<StampedPose> tentative_;
  Stay stay_;
};

}  // namespace waymark::particles
