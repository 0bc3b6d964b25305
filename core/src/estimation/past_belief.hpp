// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estimation/process_model.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::estimation {

/// A belief at an earlier time, given all measurements until now (docs/math/time.md). Its storage is kept between
/// calls, so that warm steps do not allocate.
struct PastBelief {
  Belief past;             ///< at the earlier time
  Belief predicted;        ///< from there to now, without the measurements in between
  ErrorMatrix P_now_past;  ///< Cov(present state, past state)

  /// Predicts `record`, an older belief, to `stamp`. The information about the blocks since then is carried back from
  /// `now` by one step of the Rauch–Tung–Striebel smoother (1965). Given the blocks, the past state and all later
  /// measurements are taken as independent; for a sampled pose this follows from sampling.
  void compute(const ProcessModel& process, const Belief& now, const Belief& record, Time stamp);
};

}  // namespace waymark::estimation
