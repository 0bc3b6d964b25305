// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::scan_matching {

/// Where a particle has written its map last. Where nothing but the scans measures the motion, each is matched, and one
/// is written after a distance or a turn: those of a robot that stands, and those that a turn distorts, would else
/// outweigh what was seen before.
class LastWritten {
 public:
  void set(const Pose& T_map_base) { T_map_base_ = T_map_base; }
  bool is_near(const Pose& T_map_base, const ScanSettings& settings) const {
    return T_map_base_ && (T_map_base.p - T_map_base_->p).norm() < settings.update_distance &&
           T_map_base_->q.angularDistance(T_map_base.q) < settings.update_angle;
  }

  template <class Archive>
  void serialize(Archive& archive) {
    bool is_set = T_map_base_.has_value();
    archive(is_set);
    if constexpr (Archive::kReads) T_map_base_ = is_set ? std::optional<Pose>(Pose{}) : std::nullopt;
    if (is_set) archive(T_map_base_->p, T_map_base_->q);
  }

 private:
  std::optional<Pose> T_map_base_;
};

}  // namespace waymark::scan_matching
