// SPDX-License-Identifier: Apache-2.0
#include "particles/stay.hpp"

#include <cmath>

namespace waymark::particles {

namespace {

bool is_near(const Pose& a, const Pose& b) {
  constexpr double kReach = 0.1;       // [m]
  constexpr double kHalfTurn = 0.995;  // cosine of half of 0.2 rad, as the quaternions have it
  return (a.p - b.p).squaredNorm() <= kReach * kReach && std::abs(a.q.dot(b.q)) >= kHalfTurn;
}

}  // namespace

bool Stay::replaces_last(Time stamp, const Pose& T_map_base) {
  if (!began_ || !is_near(T_map_begin_, T_map_base)) {
    T_map_begin_ = T_map_base;
    began_ = kept_ = last_ = stamp;
    return false;
  }
  const Duration until_last = last_ - *began_;
  const bool keeps_last = until_last <= kWhole || last_ - kept_ >= until_last / kPartsOfTime;
  if (keeps_last) kept_ = last_;
  last_ = stamp;
  return !keeps_last;
}

}  // namespace waymark::particles
