// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/archive.hpp"

/// Times in which a fix is worth less than it states. All factors are of the variance and at least 1.
namespace waymark::dgps {

/// After a change of fix type or of several satellites the receiver's own filter has not settled yet.
class Settling {
 public:
  /// Reads `settling_s`, `settling_factor`, `settling_satellites`.
  explicit Settling(const Config& config);

  /// 1 + (f² − 1) exp(−t/τ) at t after the last change; 1 from 3 τ on.
  double factor(Time stamp, const GnssFix& fix);

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("settling", 1);
    archive(type_);
    archive.within(satellites_, -1, 1 << 30);
    archive(changed_);
  }

 private:
  double time_;
  double sigma_factor_;
  int satellites_change_;

  GnssFix::Type type_ = GnssFix::Type::unknown;
  int satellites_ = -1;
  std::optional<Time> changed_;
};

/// After an outage the fixes come back softly: their variance begins at f² and is 1 again after n fixes, and while they
/// do so, no fix moves the position by more than three of its predicted standard deviations.
class Reacquisition {
 public:
  /// Reads `outage_s`, `reacquisition_fixes`, `reacquisition_factor`.
  explicit Reacquisition(const Config& config);

  /// Of a fix with this innovation; `prior` is the covariance of the antenna's predicted place and `R` the fix's own,
  /// both in the plane [m²]. Call once for each fix that is fused.
  double factor(Time stamp, const Eigen::Vector2d& innovation, const Eigen::Matrix2d& prior, const Eigen::Matrix2d& R);

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("reacquisition", 1);
    archive(last_, usual_s_);
    archive.within(left_, 0, fixes_);
  }

 private:
  Duration outage_;
  int fixes_;
  double sigma_factor_;

  std::optional<Time> last_;
  double usual_s_ = 0.0;  // between two fixes
  int left_ = 0;
};

}  // namespace waymark::dgps
