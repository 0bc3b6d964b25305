// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "estimation/ekf.hpp"
#include "estimation/state_jacobian.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::particles {

/// The time of an update or of a mapping step: the present, or the stamp of a late measurement. It gives the particles'
/// beliefs at that time, and the effect on their present state.
class Instant {
 public:
  virtual ~Instant() = default;

  /// Belief of particle `slot` at this time.
  virtual Belief& belief(std::size_t slot) = 0;
  /// Moments of the mixture at this time, the poses in ENU.
  virtual const Belief& mixture() = 0;
  /// Replaces P Hᵀ of the state at this time by Cov(present state, state at this time) Hᵀ.
  virtual void carry_gain(std::size_t slot, const estimation::StateJacobian& H,
                          estimation::ekf::Innovation& innovation) = 0;
  /// Samples the poses of particles whose maps write, before they do.
  virtual void sample(std::uint32_t sensor) = 0;
  /// Records the paths and resamples, after the maps were written.
  virtual void conclude_mapping(std::uint32_t sensor) = 0;
};

}  // namespace waymark::particles
