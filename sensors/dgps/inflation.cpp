// SPDX-License-Identifier: Apache-2.0
#include "inflation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace waymark::dgps {

namespace {

constexpr double kSettled = 3.0;     // time constants
constexpr double kUsual = 3.0;       // an outage is also so many usual intervals long
constexpr double kStepSigmas = 3.0;  // largest step of the position
constexpr double kLargestFactor = 1e6;

/// The squared step d = C (C + R)⁻¹ ν in units of C, the covariance before it.
double squared_step(const Eigen::Vector2d& innovation, const Eigen::Matrix2d& C, const Eigen::Matrix2d& R) {
  const Eigen::Vector2d weighted = (C + R).inverse() * innovation;
  return weighted.dot(C * weighted);
}

}  // namespace

Settling::Settling(const Config& config)
    : time_(config.non_negative({"settling_s", "s",
                                 "time constant with which σ returns to its usual value after a change of fix type, or "
                                 "of `settling_satellites`; 0: off"},
                                3.0)),
      sigma_factor_(config.number_in(
          {"settling_factor",
           "factor on σ after a change of fix type, or of `settling_satellites`; decays with `settling_s`"},
          1.0, 100.0, 3.0)),
      satellites_change_(static_cast<int>(config.integer_in(
          {"settling_satellites", "a change of the number of satellites by so many counts"}, 1, 100, 3))) {}

double Settling::factor(Time stamp, const GnssFix& fix) {
  // What a sentence does not hold has not changed.
  const bool typed = fix.type != GnssFix::Type::unknown && type_ != GnssFix::Type::unknown;
  const bool counted = fix.satellites >= 0 && satellites_ >= 0;
  if ((typed && fix.type != type_) || (counted && std::abs(fix.satellites - satellites_) >= satellites_change_)) {
    changed_ = stamp;
  }
  if (fix.type != GnssFix::Type::unknown) type_ = fix.type;
  if (fix.satellites >= 0) satellites_ = fix.satellites;
  if (!changed_) return 1.0;
  const double since = std::max(to_seconds(stamp - *changed_), 0.0);  // a fix may come late
  if (since >= kSettled * time_) {
    changed_.reset();
    return 1.0;
  }
  return 1.0 + (sigma_factor_ * sigma_factor_ - 1.0) * std::exp(-since / time_);
}

Reacquisition::Reacquisition(const Config& config)
    : outage_(from_seconds(config.positive(
          {"outage_s", "s", "a longer gap is an outage, if it is also three times the usual one"}, 5.0))),
      fixes_(static_cast<int>(
          config.integer_in({"reacquisition_fixes",
                             "after an outage σ is multiplied by `reacquisition_factor`, decaying over so many fixes, "
                             "and none of them moves the position by more than 3σ of its prediction; 0: off"},
                            0, 1000, 3))),
      sigma_factor_(
          config.number_in({"reacquisition_factor", "factor on σ after an outage; decays over `reacquisition_fixes`"},
                           1.0, 100.0, 2.0)) {}

double Reacquisition::factor(Time stamp, const Eigen::Vector2d& innovation, const Eigen::Matrix2d& prior,
                             const Eigen::Matrix2d& R) {
  const Duration gap = last_ ? stamp - *last_ : Duration::zero();
  last_ = stamp;
  if (gap > outage_ && to_seconds(gap) > kUsual * usual_s_) {
    left_ = fixes_;
  } else if (gap > Duration::zero()) {
    usual_s_ = to_seconds(gap);
  }
  if (left_ == 0) return 1.0;
  double factor = std::pow(sigma_factor_, 2.0 * left_ / fixes_);
  --left_;
  while (factor < kLargestFactor && squared_step(innovation, prior, factor * R) > kStepSigmas * kStepSigmas) {
    factor *= 2.0;
  }
  return factor;
}

}  // namespace waymark::dgps
