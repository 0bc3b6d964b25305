// SPDX-License-Identifier: Apache-2.0
#include "field_monitor.hpp"

#include <cmath>
#include <numbers>

namespace waymark::compass {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kFollowTime = 20.0;             // of the reference [s]
constexpr double kAdoptTime = 10.0;              // a steady field for so long [s]
constexpr double kAdoptTurn = std::numbers::pi;  // and so much of a turn
constexpr double kLongClear = 1e6;               // [s]

}  // namespace

FieldMonitor::FieldMonitor(const Config& config)
    : strength_limit_(config.non_negative(
          {"field_strength_limit",
           "a field whose strength strays farther from the Earth's, as a share of it, is not used; 0: not looked at; "
           "the Earth's is the model's (`declination: auto`), else a reference that follows the undisturbed field"},
          0.15)),
      dip_limit_(kDegree * config.non_negative(
                               {"field_dip_limit_deg", "°",
                                "a field whose dip strays farther from the Earth's is not used; 0: not looked at"},
                               10.0)),
      settle_s_(config.non_negative(
          {"field_settle_s", "s", "the field is undisturbed for so long before it is used again"}, 0.5)) {}

bool FieldMonitor::near(const Eigen::Vector2d& field, const Eigen::Vector2d& reference) const {
  const bool strength =
      strength_limit_ == 0.0 || std::abs(field.x() - reference.x()) <= strength_limit_ * reference.x();
  return strength && (dip_limit_ == 0.0 || std::abs(field.y() - reference.y()) <= dip_limit_);
}

bool FieldMonitor::judge(const Eigen::Vector3d& m_map, const magnetic_model::Field& earth, double dt, double turn) {
  const Eigen::Vector2d field(m_map.norm(), std::atan2(-m_map.z(), m_map.head<2>().norm()));
  if (!known_) {
    known_ = true;
    reference_ = field;
    clear_s_ = kLongClear;  // the first one is not after a disturbance
  }
  const bool by_model = earth.strength_t && earth.dip;
  if (by_model) reference_ = {*earth.strength_t, *earth.dip};
  if (!near(field, reference_)) {
    clear_s_ = 0.0;
    if (!by_model) consider(field, dt, turn);
    return false;
  }
  candidate_s_ = 0.0;
  clear_s_ += dt;
  if (clear_s_ < settle_s_) return false;
  if (!by_model) reference_ += -std::expm1(-dt / kFollowTime) * (field - reference_);
  return true;
}

void FieldMonitor::consider(const Eigen::Vector2d& field, double dt, double turn) {
  if (candidate_s_ == 0.0 || !near(field, candidate_)) {
    candidate_ = field;
    candidate_s_ = dt;
    candidate_turn_ = 0.0;
    return;
  }
  candidate_s_ += dt;
  candidate_turn_ += std::abs(turn);
  candidate_ += -std::expm1(-dt / kFollowTime) * (field - candidate_);
  if (candidate_s_ < kAdoptTime || candidate_turn_ < kAdoptTurn) return;
  reference_ = candidate_;
  candidate_s_ = 0.0;
}

}  // namespace waymark::compass
