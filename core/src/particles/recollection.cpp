// SPDX-License-Identifier: Apache-2.0
#include "particles/recollection.hpp"

#include <functional>

#include "particles/update_step.hpp"

namespace waymark::particles {

Recollection::Recollection(const estimation::ProcessModel& process, const ParticleSet& particles,
                           MixtureMoments& moments, Workers& workers, Duration span)
    : process_(process),
      particles_(particles),
      moments_(moments),
      workers_(workers),
      past_(span),
      recalled_(particles.size()) {}

void Recollection::remember() {
  const Time now = particles_[0].belief.stamp;
  if (!past_.is_due(now)) return;
  std::vector<Belief>& record = past_.add(now, particles_.size());
  for (std::size_t i = 0; i < particles_.size(); ++i) record[i] = particles_[i].belief;
}

bool Recollection::recall(Time stamp) {
  if (!past_.reach(stamp)) return false;
  past_.find(stamp, particles_.size(), beliefs_);
  const auto recall_one = [&](int slot) {
    const auto i = static_cast<std::size_t>(slot);
    recalled_[i].compute(process_, particles_[i].belief, *beliefs_[i], stamp);
  };
  workers_.for_each(static_cast<int>(particles_.size()), std::cref(recall_one), kSerialUpdates);
  for (std::size_t i = 0; i < particles_.size(); ++i) beliefs_[i] = &recalled_[i].past;
  moments_.compute(beliefs_, particles_, mixture_);
  return true;
}

void Recollection::carry_gain(std::size_t slot, const estimation::StateJacobian& H,
                              estimation::ekf::Innovation& innovation) {
  innovation.PHt = estimation::ekf::project(recalled_[slot].P_now_past, H);
}

}  // namespace waymark::particles
