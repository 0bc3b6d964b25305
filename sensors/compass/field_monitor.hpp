// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "earth_field.hpp"
#include "waymark/config/config.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::compass {

/// Is this the Earth's field? Strength and dip against the model, or, without one, against a reference that follows the
/// undisturbed field slowly. There, another field that stays the same while the robot turns is the place's field and
/// becomes the reference: one that moves along with the robot would change (after D. Laidig, T. Seel, "VQF",
/// Information Fusion 91, 2023, sec. 3.4; own thresholds).
class FieldMonitor {
 public:
  /// Reads `field_strength_limit`, `field_dip_limit_deg`, `field_settle_s`.
  explicit FieldMonitor(const Config& config);

  /// True if the field may be used. `m_map`: the field in the map, of which the heading does not count; `dt`: since the
  /// one before [s]; `turn`: of the robot meanwhile [rad].
  bool judge(const Eigen::Vector3d& m_map, const magnetic_model::Field& earth, double dt, double turn);

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("field_monitor", 1);
    archive(known_, reference_, candidate_, candidate_s_, candidate_turn_, clear_s_);
  }

 private:
  bool near(const Eigen::Vector2d& field, const Eigen::Vector2d& reference) const;
  void consider(const Eigen::Vector2d& field, double dt, double turn);

  double strength_limit_;  // relative
  double dip_limit_;       // [rad]
  double settle_s_;

  bool known_ = false;
  Eigen::Vector2d reference_ = Eigen::Vector2d::Zero();  // strength [T], dip [rad]
  Eigen::Vector2d candidate_ = Eigen::Vector2d::Zero();
  double candidate_s_ = 0.0;
  double candidate_turn_ = 0.0;
  double clear_s_ = 0.0;  // undisturbed since
};

}  // namespace waymark::compass
