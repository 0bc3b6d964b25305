// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace waymark::particles {

/// Detects that matches and motion contradict each other: many matches in a row lie beyond what the motion expects, all
/// to the same side. So a map of two dimensions holds a robot that drives up a ramp. Where the noise of the wheels is
/// too small for them, matches jump to all sides.
class JumpWatch {
 public:
  /// Adds a mapping step: how far its match lies from the prior mean, in the base's axes and in σ of the prior; zero if
  /// the prior expects it.
  void add(const Eigen::Vector3d& jump) {
    const bool is_expected = jump.isZero(0.0);
    if (is_expected || (sum_ + jump).norm() < kOneSided * (length_ + jump.norm())) *this = {};
    if (is_expected) return;
    sum_ += jump;
    length_ += jump.norm();
    ++in_a_row_;
  }
  bool is_one_sided() const { return in_a_row_ >= kMany; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(sum_, length_, in_a_row_);
  }

 private:
  static constexpr std::uint64_t kMany = 7;  // 9 to 30 on a ramp, at most 6 on right maps
  static constexpr double kOneSided = 0.95;  // length of the sum by the sum of lengths

  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();  // of the jumps in a row to one side
  double length_ = 0.0;                            // of each, summed up
  std::uint64_t in_a_row_ = 0;
};

}  // namespace waymark::particles
