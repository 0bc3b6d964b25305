// SPDX-License-Identifier: Apache-2.0
#include "estimation/state_jacobian.hpp"

namespace waymark::estimation {

void scatter(const StateLayout& layout, int block_offset, const Linearization& model, StateJacobian& out,
             Linearization::Part first_part) {
  for (int part = first_part; part < 4; ++part) {
    const auto p = static_cast<Linearization::Part>(part);
    if (!model.uses(p)) continue;
    for (int axis = 0; axis < 3; ++axis) out.add(layout.active(3 * part + axis), model.get(p).col(axis));
  }
  if (!model.uses_block()) return;
  const int first = layout.core_size() + block_offset;
  const auto size = static_cast<int>(model.get_block().cols());
  for (int i = 0; i < size; ++i) out.add(first + i, model.get_block().col(i));
  if (!model.estimates_block()) {
    out.considered = size;
    out.first_considered = first;
  }
}

bool observes_speed(const Linearization& model) {
  return model.uses(Linearization::kVelocity) && !model.get(Linearization::kVelocity).col(0).isZero(0.0);
}

}  // namespace waymark::estimation
