// SPDX-License-Identifier: Apache-2.0
#include "heading_monitor.hpp"

namespace waymark::compass {

HeadingMonitor::HeadingMonitor(const Config& config)
    : jump_sigmas_(config.non_negative(
          {"jump_sigmas", "a heading farther than so many σ from the prediction is rejected; 0: off"}, 6.0)),
      patience_(from_seconds(config.non_negative(
          {"jump_patience_s", "s", "a rejected heading is accepted if it stays for so long; 0: off"}, 20.0))) {}

bool HeadingMonitor::judge(Time stamp, double innovation, double variance) {
  if (jump_sigmas_ == 0.0 || !known_ || innovation * innovation <= jump_sigmas_ * jump_sigmas_ * variance) {
    known_ = true;
    jumping_since_.reset();
    return true;
  }
  if (!jumping_since_) jumping_since_ = stamp;
  return stamp - *jumping_since_ >= patience_;
}

}  // namespace waymark::compass
