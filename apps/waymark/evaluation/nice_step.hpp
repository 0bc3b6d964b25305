// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace waymark::evaluation {

/// 1, 2 or 5 times a power of ten: some six steps over `span`.
inline double nice_step(double span) {
  const double rough = span / 6.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace waymark::evaluation
