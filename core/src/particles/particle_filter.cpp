// SPDX-License-Identifier: Apache-2.0
#include "particles/particle_filter.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <exception>

#include "particles/resampling.hpp"
#include "waymark/base/error.hpp"

namespace waymark::particles {

namespace {

// What a random stream is for, where it is not a sensor's.
constexpr std::uint32_t kStartDraw = 0xFFFFFFFF;
constexpr std::uint32_t kResampling = 0x80000000;  // + sensor

// Particles whose moments are summed up in one go: fixed, so that sums do not depend on the number of threads.
constexpr std::size_t kMomentsChunk = 8;

}  // namespace

Gates::Gates(double probability) {
  for (int rows = 1; rows <= kMaxUpdateRows; ++rows) {
    quantiles_[static_cast<std::size_t>(rows)] = gaussian::chi_squared_quantile(probability, rows);
  }
}

ParticleFilter::ParticleFilter(const estimation::ProcessModel& process, std::vector<std::shared_ptr<MapModule>> modules,
                               const ParticleFilterSettings& settings,
                               std::optional<estimation::Georeference> georeference)
    : process_(process),
      modules_(std::move(modules)),
      settings_(settings),
      georeference_(georeference),
      workers_(settings.threads),
      past_(settings.history) {
  assert(settings.particles >= 1);
  particles_.resize(static_cast<std::size_t>(settings.particles));
  scratch_.resize(particles_.size());
  log_weights_.resize(particles_.size());
  moments_.resize((particles_.size() + kMomentsChunk - 1) / kMomentsChunk);
}

template <class Body>
void ParticleFilter::for_each_particle(const Body& body) {
  // Through a reference the std::function needs no heap.
  workers_.for_each(static_cast<int>(particles_.size()), std::cref(body), kSerialUpdates);
}

Random ParticleFilter::random(int slot, std::uint32_t purpose) const {
  return Random({settings_.seed, static_cast<std::uint32_t>(slot), stamp().time_since_epoch().count(), purpose});
}

void ParticleFilter::start(const Belief& prior, bool draw) {
  for (Particle& particle : particles_) {
    particle = Particle{};
    particle.belief = prior;
    for (const auto& module : modules_) particle.maps.push_back(module ? module->create_map() : nullptr);
  }
  // One particle alone has no others that stand for the draws it did not make: it keeps the whole prior.
  if (georeference_) {
    for (Particle& particle : particles_) georeference_->take_over_start(particle.belief);
  } else if (draw && particles_.size() > 1) {
    for (std::size_t slot = 0; slot < particles_.size(); ++slot) {
      Random stream = random(static_cast<int>(slot), kStartDraw);
      estimation::ekf::sample_pose(particles_[slot].belief, layout(), settings_.sampling_fraction, stream);
    }
  }
  past_.clear();
  normalize();
}

void ParticleFilter::predict(Time to, bool standing) {
  if (to == stamp()) return;
  for_each_particle(
      [&](int slot) { process_.predict(particles_[static_cast<std::size_t>(slot)].belief, to, standing); });
  mixture_valid_ = false;
}

MixtureOutcome ParticleFilter::update(const Update& model, const UpdatePolicy& policy) {
  for_each_particle(
      [&](int slot) { innovate(slot, particles_[static_cast<std::size_t>(slot)].belief, model, policy, false); });
  return weigh_and_apply(policy);
}

/// Prepares the update of one particle out of what it believes of the measurement's time. `late`: that is not now, so
/// the gain is that of the state now, through its cross-covariance with the state then.
void ParticleFilter::innovate(int slot, const Belief& belief, const Update& model, const UpdatePolicy& policy,
                              bool late) {
  const int offset = layout().block_offset(policy.owner);
  Scratch& scratch = scratch_[static_cast<std::size_t>(slot)];
  scratch.failed_input = -1;
  try {
    const bool through_earth = georeference_ && policy.absolute;
    estimation::EarthJacobian earth;
    if (through_earth) {
      scratch.enu = georeference_->in_enu(belief.mean);
      earth = georeference_->jacobian(belief.mean);
    }
    const estimation::EarthJacobian* jacobian = through_earth ? &earth : nullptr;
    const NavState& state = through_earth ? scratch.enu : belief.mean;
    model.linearize({state, state.block.data() + offset}, scratch.model);
    estimation::ekf::innovate(belief, layout(), policy.owner, scratch.model, scratch.innovation, jacobian);
    if (late) {
      scratch.innovation.PHt =
          estimation::ekf::project(scratch.now_and_then, layout(), policy.owner, scratch.model, jacobian);
    }
  } catch (const std::exception& error) {
    scratch.failed_input = 0;
    scratch.failure = error.what();
  } catch (...) {
    scratch.failed_input = 0;
    scratch.failure = "unknown exception";
  }
}

/// The gate on the mixture's innovation, the update of every particle, and its evidence into the weights.
MixtureOutcome ParticleFilter::weigh_and_apply(const UpdatePolicy& policy) {
  MixtureOutcome outcome;
  for (const Scratch& scratch : scratch_) {
    if (scratch.failed_input >= 0) throw Error(scratch.failure);
    outcome.usable = outcome.usable && scratch.innovation.finite;
  }
  if (!outcome.usable) return outcome;

  const int rows = static_cast<int>(scratch_.front().innovation.nu.size());
  outcome.innovation.setZero(rows);
  outcome.S.setZero(rows, rows);
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    outcome.innovation += std::exp(particles_[i].log_weight) * scratch_[i].innovation.nu;
  }
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const gaussian::Vector spread = scratch_[i].innovation.nu - outcome.innovation;
    outcome.S += std::exp(particles_[i].log_weight) * (scratch_[i].innovation.S + spread * spread.transpose());
  }
  outcome.nis = gaussian::density(outcome.innovation, outcome.S).squared_mahalanobis;
  const double gate = policy.gates[rows];
  outcome.accepted = policy.ignore_gate || outcome.nis <= gate;

  for_each_particle([&](int slot) {
    Particle& particle = particles_[static_cast<std::size_t>(slot)];
    const estimation::ekf::Innovation& innovation = scratch_[static_cast<std::size_t>(slot)].innovation;
    double log_evidence = innovation.density.log_density;
    if (outcome.accepted) {
      estimation::ekf::apply(particle.belief, layout(), innovation);
    } else {
      const double nis = innovation.density.squared_mahalanobis;
      log_evidence += 0.5 * (nis - std::min(nis, gate));
    }
    particle.log_weight += policy.weight_exponent * log_evidence;
  });
  normalize();
  return outcome;
}

void ParticleFilter::stop() {
  for (Particle& particle : particles_) estimation::ekf::stop(particle.belief, layout());
  mixture_valid_ = false;
}

void ParticleFilter::release(double velocity_sigma, double rate_sigma) {
  for (Particle& particle : particles_) estimation::ekf::release(particle.belief, layout(), velocity_sigma, rate_sigma);
  mixture_valid_ = false;
}

void ParticleFilter::inflate_pose(double position_variance, double yaw_variance) {
  const auto& index = layout().pose_indices();
  mixture_valid_ = false;
  if (georeference_) {
    // A turn about the map's origin would throw a robot far from it off the map: only the position is set free.
    for (Particle& particle : particles_) georeference_->inflate(particle.belief, position_variance, 0.0);
    return;
  }
  for (Particle& particle : particles_) {
    particle.belief.P(index[0], index[0]) += position_variance;
    particle.belief.P(index[1], index[1]) += position_variance;
    particle.belief.P(index[2], index[2]) += yaw_variance;
  }
}

void ParticleFilter::record_path() {
  for (Particle& particle : particles_) particle.path.append(particle.belief.stamp, particle.belief.mean.T_map_base);
}

void ParticleFilter::record_tentative_path() {
  for (Particle& particle : particles_)
    particle.path.append_tentative(particle.belief.stamp, particle.belief.mean.T_map_base);
}

void ParticleFilter::resample_if_needed(std::uint32_t sensor) {
  const double count = static_cast<double>(particles_.size());
  if (particles_.size() < 2 || effective_sample_size() >= settings_.resample_threshold * count) return;
  for (std::size_t i = 0; i < particles_.size(); ++i) log_weights_[i] = particles_[i].log_weight;
  const std::vector<int> ancestors = systematic_resample(log_weights_, random(-1, kResampling + sensor).uniform());
  std::vector<Particle> next;
  next.reserve(particles_.size());
  for (std::size_t slot = 0; slot < ancestors.size(); ++slot) {
    const bool last_child = slot + 1 == ancestors.size() || ancestors[slot + 1] != ancestors[slot];
    Particle& parent = particles_[static_cast<std::size_t>(ancestors[slot])];
    next.push_back(last_child ? std::move(parent) : parent.clone());
    next.back().log_weight = -std::log(count);
  }
  particles_ = std::move(next);
  past_.resampled(ancestors);
  ++resamplings_;
  mixture_valid_ = false;
}

void ParticleFilter::drop_module(int module) {
  modules_[static_cast<std::size_t>(module)] = nullptr;
  for (Particle& particle : particles_) {
    if (static_cast<std::size_t>(module) < particle.maps.size())
      particle.maps[static_cast<std::size_t>(module)] = nullptr;
  }
}

void ParticleFilter::normalize() {
  for (std::size_t i = 0; i < particles_.size(); ++i) log_weights_[i] = particles_[i].log_weight;
  normalize_log_weights(log_weights_);
  for (std::size_t i = 0; i < particles_.size(); ++i) particles_[i].log_weight = log_weights_[i];
  mixture_valid_ = false;
}

double ParticleFilter::effective_sample_size() const {
  double sum = 0.0;
  for (const Particle& particle : particles_) sum += std::exp(2.0 * particle.log_weight);
  return 1.0 / sum;
}

int ParticleFilter::best() const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < particles_.size(); ++i) {
    if (particles_[i].log_weight > particles_[best].log_weight) best = i;
  }
  return static_cast<int>(best);
}

const Belief& ParticleFilter::mixture() const {
  if (!mixture_valid_) compute_mixture();
  return mixture_;
}

void ParticleFilter::compute_mixture() const {
  mixture_valid_ = true;
  beliefs_.resize(particles_.size());
  for (std::size_t i = 0; i < particles_.size(); ++i) beliefs_[i] = &particles_[i].belief;
  compute_moments(beliefs_, mixture_);
}

void ParticleFilter::sum_moments(std::size_t chunk, std::span<const Belief* const> beliefs,
                                 const NavState& center) const {
  Moments& sums = moments_[chunk];
  const int n = layout().size();
  sums.mean.setZero(n);
  sums.P.setZero(n, n);
  sums.widest_turn = 0.0;
  const std::size_t end = std::min(particles_.size(), (chunk + 1) * kMomentsChunk);
  for (std::size_t i = chunk * kMomentsChunk; i < end; ++i) {
    const Belief* belief = beliefs[i];
    if (georeference_) {
      sums.enu = *belief;
      georeference_->to_enu(sums.enu);
      belief = &sums.enu;
    }
    const double weight = std::exp(particles_[i].log_weight);
    const ErrorVector spread = boxminus(belief->mean, center, layout());
    sums.mean += weight * spread;
    sums.P += weight * belief->P + (weight * spread).lazyProduct(spread.transpose());
    sums.widest_turn = std::max(sums.widest_turn, std::abs(spread[layout().pose_indices()[2]]));
  }
}

/// Moments of one belief per slot, weighted as the particles are.
void ParticleFilter::compute_moments(std::span<const Belief* const> beliefs, Belief& mixture) const {
  mixture = *beliefs[static_cast<std::size_t>(best())];
  if (georeference_) georeference_->to_enu(mixture);
  if (particles_.size() == 1) return;
  // Moments on the manifold about the best particle: one step, repeated about the mean only where particles face ways
  // so different that the step is not exact; for the yaw this is the circular mean.
  constexpr double kSmallTurn = 0.05;  // [rad]
  ErrorVector mean;
  for (int iteration = 0; iteration < 4; ++iteration) {
    const NavState center = mixture.mean;
    const auto sum = [&](int chunk) { sum_moments(static_cast<std::size_t>(chunk), beliefs, center); };
    workers_.for_each(static_cast<int>(moments_.size()), std::cref(sum), 2);
    mean = moments_.front().mean;
    mixture.P = moments_.front().P;
    double widest_turn = moments_.front().widest_turn;
    for (std::size_t chunk = 1; chunk < moments_.size(); ++chunk) {
      mean += moments_[chunk].mean;
      mixture.P += moments_[chunk].P;
      widest_turn = std::max(widest_turn, moments_[chunk].widest_turn);
    }
    boxplus(mixture.mean, mean, layout());
    if (widest_turn < kSmallTurn || mean.squaredNorm() < 1e-24) break;
  }
  mixture.P -= mean.lazyProduct(mean.transpose());
}

}  // namespace waymark::particles
