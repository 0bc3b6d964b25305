// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "estimation/ekf.hpp"
#include "estimation/state_jacobian.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::particles {

/// The time that an update or a mapping step is about: the particles' own (now), or that of a measurement that comes
/// late. The steps are the same; an instant gives the belief of a particle that is meant and what follows for its
/// state.
class Instant {
 public:
  virtual ~Instant() = default;

  /// What particle `slot` believes of this time.
  virtual Belief& belief(std::size_t slot) = 0;
  /// Moments of the mixture at this time, the poses in ENU.
  virtual const Belief& mixture() = 0;
  /// Replaces P Hᵀ, which leads from this time's innovation to its own state, by what leads to the state of now.
  virtual void carry_gain(std::size_t slot, const estimation::StateJacobian& H,
                          estimation::ekf::Innovation& innovation) = 0;
  /// Draws the poses of particles whose maps write, before they do.
  virtual void sample(std::uint32_t sensor) = 0;
  /// After the maps were written: paths, and the particles that go on.
  virtual void conclude_mapping(std::uint32_t sensor) = 0;
};

}  // namespace waymark::particles
