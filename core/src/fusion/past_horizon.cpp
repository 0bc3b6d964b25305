// SPDX-License-Identifier: Apache-2.0
#include "fusion/horizons.hpp"

namespace waymark::fusion {

void PastHorizon::update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) {
  Committed& committed = steps().committed();
  if (index > 0) committed.filter.recall(m.stamp);  // the update before changed the past beliefs
  steps().account(m, index, committed.filter.update(at_, update, committed.record(m).policy), result);
}

}  // namespace waymark::fusion
