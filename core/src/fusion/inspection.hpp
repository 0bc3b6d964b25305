// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "particles/particle_filter.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/fusion.hpp"

namespace waymark::fusion {

/// Internal state of a host, for core's own tests.
struct Inspection {
  /// The committed particles; valid as long as the host.
  WAYMARK_API static const particles::ParticleFilter& filter(const Fusion& host);
};

}  // namespace waymark::fusion
