// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimation/georeference.hpp"
#include "particles/instant.hpp"
#include "particles/particle_set.hpp"
#include "particles/workers.hpp"

namespace waymark::particles {

/// With fewer particles one EKF update takes less time than waking a second thread.
inline constexpr int kSerialUpdates = 16;

/// One measurement model in every particle: innovate, gate on the mixture's innovation, update, weigh by the evidence.
class UpdateStep {
 public:
  /// All must outlive the object.
  UpdateStep(const StateLayout& layout, const std::optional<estimation::Georeference>& georeference, Workers& workers,
             std::size_t particles);

  /// Throws Error if the model throws for a particle; nothing is applied then. Weights are left unnormalised.
  MixtureOutcome apply(ParticleSet& particles, Instant& at, const Update& model, const UpdatePolicy& policy);

 private:
  struct Scratch {  // per slot, kept between calls so that warm steps do not allocate
    NavState enu;   // the mean with its pose in ENU
    Linearization model;
    estimation::StateJacobian H;
    estimation::ekf::Innovation innovation;
    std::optional<std::string> failure;
  };

  void innovate(std::size_t slot, Instant& at, const Update& model, const UpdatePolicy& policy);
  MixtureOutcome gate(const ParticleSet& particles, const UpdatePolicy& policy) const;
  void update(Particle& particle, const estimation::ekf::Innovation& innovation, bool accepted,
              const UpdatePolicy& policy) const;

  const StateLayout& layout_;
  const std::optional<estimation::Georeference>& georeference_;
  Workers& workers_;
  std::vector<Scratch> scratch_;
};

}  // namespace waymark::particles
