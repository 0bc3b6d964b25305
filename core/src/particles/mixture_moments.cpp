// SPDX-License-Identifier: Apache-2.0
#include "particles/mixture_moments.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace waymark::particles {

namespace {

// Particles in one partial sum: fixed, so that sums do not depend on the number of threads.
constexpr std::size_t kChunk = 8;

}  // namespace

MixtureMoments::MixtureMoments(const StateLayout& layout, const std::optional<estimation::Georeference>& georeference,
                               Workers& workers, std::size_t particles)
    : layout_(layout), georeference_(georeference), workers_(workers), sums_((particles + kChunk - 1) / kChunk) {}

void MixtureMoments::sum(std::size_t chunk, std::span<const Belief* const> beliefs, const ParticleSet& particles,
                         const NavState& center) {
  Sums& sums = sums_[chunk];
  const int n = layout_.size();
  sums.mean.setZero(n);
  sums.P.setZero(n, n);
  sums.max_yaw_deviation = 0.0;
  const std::size_t end = std::min(particles.size(), (chunk + 1) * kChunk);
  for (std::size_t i = chunk * kChunk; i < end; ++i) {
    const Belief* belief = beliefs[i];
    if (georeference_) {
      sums.enu = *belief;
      georeference_->to_enu(sums.enu);
      belief = &sums.enu;
    }
    const double weight = particles.weight(i);
    const ErrorVector spread = boxminus(belief->mean, center, layout_);
    sums.mean += weight * spread;
    sums.P += weight * belief->P + (weight * spread).lazyProduct(spread.transpose());
    sums.max_yaw_deviation = std::max(sums.max_yaw_deviation, std::abs(spread[layout_.pose_indices()[2]]));
  }
}

void MixtureMoments::compute(std::span<const Belief* const> beliefs, const ParticleSet& particles, Belief& mixture) {
  mixture = *beliefs[particles.best()];
  if (georeference_) georeference_->to_enu(mixture);
  if (particles.size() == 1) return;
  // Moments on the manifold about the best particle: one step, repeated about the mean only where headings differ so
  // much that the step is not exact; for the yaw this is the circular mean.
  constexpr double kSmallDeviation = 0.05;  // [rad]
  ErrorVector mean;
  for (int iteration = 0; iteration < 4; ++iteration) {
    const NavState center = mixture.mean;
    const auto sum_chunk = [&](int chunk) { sum(static_cast<std::size_t>(chunk), beliefs, particles, center); };
    workers_.for_each(static_cast<int>(sums_.size()), std::cref(sum_chunk), 2);
    mean = sums_.front().mean;
    mixture.P = sums_.front().P;
    double max_yaw_deviation = sums_.front().max_yaw_deviation;
    for (std::size_t chunk = 1; chunk < sums_.size(); ++chunk) {
      mean += sums_[chunk].mean;
      mixture.P += sums_[chunk].P;
      max_yaw_deviation = std::max(max_yaw_deviation, sums_[chunk].max_yaw_deviation);
    }
    boxplus(mixture.mean, mean, layout_);
    if (max_yaw_deviation < kSmallDeviation || mean.squaredNorm() < 1e-24) break;
  }
  mixture.P -= mean.lazyProduct(mean.transpose());
}

}  // namespace waymark::particles
