// SPDX-License-Identifier: Apache-2.0
#include "fix_monitor.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace waymark::dgps {

namespace {

constexpr double kSamePlace = 1e-3;    // [m]; no receiver repeats a position to the millimetre
constexpr int kRepeats = 2;            // of one position before it can count as frozen
constexpr double kAgreeSigmas = 4.0;   // of the difference of two fixes
constexpr double kAgreeStretch = 1.5;  // the way between two fixes may be so much longer than predicted
constexpr int kDisagreeing = 4;        // times the patience, for jumps that do not agree with each other either
constexpr int kPlaceFixes = 5;         // whose mean is where the robot stands

}  // namespace

FixMonitor::FixMonitor(const Config& config)
    : jump_sigmas_(config.non_negative(
          {"jump_sigmas", "a fix farther than so many σ from the prediction is rejected; 0: off"}, 6.0)),
      jump_patience_(static_cast<int>(config.integer_in(
          {"jump_patience", "rejected fixes that agree with each other are accepted after so many"}, 1, 1000, 5))),
      frozen_distance_(
          config.non_negative({"frozen_distance_m", "m",
                               "a position that does not change while the robot drives this far is rejected; 0: off"},
                              2.0)),
      drift_sigmas_(config.non_negative({"drift_sigmas",
                                         "a position that leaves the place where the robot stands by so many σ (noise "
                                         "and offset) is rejected; 0: off"},
                                        5.0)),
      drift_patience_(from_seconds(config.non_negative(
          {"drift_patience_s", "s", "a position that drifts while the robot stands is rejected for so long; 0: off"},
          60.0))) {}

std::string_view FixMonitor::reason(Verdict verdict) {
  switch (verdict) {
    case Verdict::jump:
      return "position jumps against the predicted motion";
    case Verdict::frozen:
      return "position frozen while the robot moves";
    case Verdict::drifting:
      return "position drifts while the robot stands";
    case Verdict::good:
      break;
  }
  return {};
}

FixMonitor::Verdict FixMonitor::judge(const ObservedFix& fix) {
  const double dt = last_stamp_ ? std::max(0.0, to_seconds(fix.stamp - *last_stamp_)) : 0.0;
  // Each keeps its own account, whatever the others find.
  const bool frozen = is_frozen(fix, dt);
  const bool drifting = is_drifting(fix);
  const bool jump = !frozen && is_jump(fix, dt);
  last_stamp_ = fix.stamp;
  last_ = fix.z;
  if (frozen) return Verdict::frozen;
  if (jump) return Verdict::jump;
  if (drifting) return Verdict::drifting;
  known_ = true;
  return Verdict::good;
}

bool FixMonitor::is_frozen(const ObservedFix& fix, double dt) {
  if (!last_stamp_ || (fix.z - last_).norm() > kSamePlace) {
    repeats_ = 0;
    moved_m_ = 0.0;
    return false;
  }
  ++repeats_;
  if (!fix.standing) moved_m_ += std::max(0.0, fix.speed - 2.0 * fix.speed_sigma) * dt;
  return frozen_distance_ > 0.0 && repeats_ >= kRepeats && moved_m_ > frozen_distance_;
}

bool FixMonitor::is_drifting(const ObservedFix& fix) {
  if (!fix.standing) {
    stood_ = 0;
    drifting_since_.reset();
    return false;
  }
  if (stood_ < kPlaceFixes) {
    ++stood_;
    place_ = stood_ == 1 ? fix.z : Eigen::Vector2d(place_ + (fix.z - place_) / stood_);
    return false;
  }
  if (drift_sigmas_ == 0.0 || (fix.z - place_).norm() <= drift_sigmas_ * fix.sigma) {
    drifting_since_.reset();
    return false;
  }
  if (!drifting_since_) drifting_since_ = fix.stamp;
  if (fix.stamp - *drifting_since_ < drift_patience_) return true;
  stood_ = 1;  // so long, and still there: this is where it stands
  place_ = fix.z;
  drifting_since_.reset();
  return false;
}

bool FixMonitor::is_jump(const ObservedFix& fix, double dt) {
  const Eigen::LLT<Eigen::Matrix2d> factor(fix.S);
  const double distance2 = fix.innovation.dot(factor.solve(fix.innovation));
  // The first fix has nothing to jump from, and one that follows the last accepted ones has not jumped: the host's gate
  // judges them.
  if (jump_sigmas_ == 0.0 || !known_ || fix.follows || distance2 <= jump_sigmas_ * jump_sigmas_) {
    agreeing_ = jumps_ = 0;
    believing_ = false;
    return false;
  }
  // A filter that is wrong in its heading predicts the way's direction wrong, too: only the length counts.
  const double way = kAgreeStretch * (fix.speed + 2.0 * fix.speed_sigma) * dt;
  const bool agrees = last_stamp_ && (fix.z - last_).norm() <= way + kAgreeSigmas * std::sqrt(2.0) * fix.sigma;
  if (believing_ && agrees) return false;
  believing_ = false;
  agreeing_ = agrees || jumps_ == 0 ? agreeing_ + 1 : 1;
  ++jumps_;
  if (agreeing_ <= jump_patience_ && jumps_ <= kDisagreeing * jump_patience_) return true;
  believing_ = true;
  agreeing_ = jumps_ = 0;
  return false;
}

}  // namespace waymark::dgps
