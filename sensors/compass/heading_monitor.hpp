// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::compass {

/// A heading that jumps against the predicted turn is rejected, but not for ever: if it stays so, the filter is wrong.
class HeadingMonitor {
 public:
  /// Reads `jump_sigmas`, `jump_patience_s`.
  explicit HeadingMonitor(const Config& config);

  /// True if the heading may be used. `innovation` [rad], `variance`: of it [rad²].
  bool judge(Time stamp, double innovation, double variance);

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("heading_monitor", 1);
    archive(known_, jumping_since_);
  }

 private:
  double jump_sigmas_;
  Duration patience_;

  bool known_ = false;  // a heading has been good already
  std::optional<Time> jumping_since_;
};

}  // namespace waymark::compass
