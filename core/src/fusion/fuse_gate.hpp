// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>

#include "waymark/host/fusion_settings.hpp"

namespace waymark::fusion {

/// Selects the measurements to fuse, in stamp order.
class FuseGate {
 public:
  explicit FuseGate(const FuseRule& rule) : rule_(rule) {}

  /// True if the next measurement is fused. Call it once per measurement.
  bool fuses(Time stamp) {
    if (!first_) first_ = stamp;
    if (last_ && stamp - *last_ > rule_.gap) ++stretch_;
    last_ = std::max(last_.value_or(stamp), stamp);  // it may be late
    switch (rule_.mode) {
      case FuseRule::Mode::all:
        return true;
      case FuseRule::Mode::alternate:
        return (stamp - *first_) % (rule_.on + rule_.off) < rule_.on;
      case FuseRule::Mode::stretches:
        return stretch_ % 2 == 0;
      case FuseRule::Mode::start:  // the start is already found
      case FuseRule::Mode::none:
        return false;
    }
    return true;
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(first_, last_);
    archive.within(stretch_, 0, 1 << 30);
  }

 private:
  FuseRule rule_;
  std::optional<Time> first_;
  std::optional<Time> last_;
  int stretch_ = 0;
};

}  // namespace waymark::fusion
