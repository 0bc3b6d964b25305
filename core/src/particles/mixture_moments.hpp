// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "estimation/georeference.hpp"
#include "particles/particle_set.hpp"
#include "particles/workers.hpp"

namespace waymark::particles {

/// Mean and covariance of the particles' beliefs, the poses in ENU: the mean on the manifold (circular for the
/// attitude), the covariance within plus between the particles.
class MixtureMoments {
 public:
  /// All must outlive the object.
  MixtureMoments(const StateLayout& layout, const std::optional<estimation::Georeference>& georeference,
                 Workers& workers, std::size_t particles);

  /// `beliefs`: one per slot, weighted as the particles are.
  void compute(std::span<const Belief* const> beliefs, const ParticleSet& particles, Belief& mixture);

 private:
  /// Weighted sums over some particles, relative to a center.
  struct Sums {
    ErrorVector mean;
    ErrorMatrix P;                   // within and between the particles
    double max_yaw_deviation = 0.0;  // [rad]
    Belief enu;                      // scratch
  };
  void sum(std::size_t chunk, std::span<const Belief* const> beliefs, const ParticleSet& particles,
           const NavState& center);

  const StateLayout& layout_;
  const std::optional<estimation::Georeference>& georeference_;
  Workers& workers_;
  std::vector<Sums> sums_;
};

}  // namespace waymark::particles
