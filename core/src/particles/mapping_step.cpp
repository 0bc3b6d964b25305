// SPDX-License-Identifier: Apache-2.0
#include "particles/mapping_step.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::particles {

namespace {

constexpr std::uint32_t kPriorDraw = 0x40000000;  // + sensor: purpose of this random stream
constexpr int kSerialMapping = 2;                 // a single particle is mapped by the calling thread

/// Adds the NIS of information Λ, η about a prior with covariance P: the maximum d of η and Λ alone has the covariance
/// P + Λ⁻¹. Directions without information are left out.
template <class Matrix, class Vector>
void add_innovation(const Matrix& information, const Vector& gradient, const Matrix& P, MapInnovation& out) {
  constexpr double kNothing = 1e-9;  // of the largest
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(information);
  const double least = kNothing * eigen.eigenvalues().maxCoeff();
  if (!(least > 0.0)) return;
  Matrix S = eigen.eigenvectors().transpose() * P * eigen.eigenvectors();
  Vector d = eigen.eigenvectors().transpose() * gradient;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value > least) {
      d[i] /= value;
      S(i, i) += 1.0 / value;
      ++out.dof;
    } else {
      S.row(i).setZero();
      S.col(i).setZero();
      S(i, i) = 1.0;
      d[i] = 0.0;
    }
  }
  out.nis += d.dot(S.llt().solve(d));
}

void add_innovation(const Refinement& refinement, double share, const PoseGaussian& prior, MapInnovation& out) {
  if (refinement.spatial && prior.P_spatial) {
    add_innovation<SpatialMatrix, SpatialVector>(share * refinement.spatial->information,
                                                 share * refinement.spatial->gradient, *prior.P_spatial, out);
  } else {
    add_innovation<Eigen::Matrix3d, Eigen::Vector3d>(share * refinement.information, share * refinement.gradient,
                                                     prior.P, out);
  }
}

/// The pose, farther by `d` = (x [m], y [m], yaw [rad]).
Pose displaced(Pose pose, const Eigen::Vector3d& d) {
  pose.p.head<2>() += d.head<2>();
  pose.q = (so3::exp({0.0, 0.0, d.z()}) * pose.q).normalized();
  return pose;
}

}  // namespace

MappingStep::MappingStep(const StateLayout& layout, Workers& workers, const RandomStreams& streams,
                         std::size_t particles, MayJump may_jump)
    : layout_(layout), workers_(workers), streams_(streams), may_jump_(std::move(may_jump)), scratch_(particles) {}

void MappingStep::keep_priors(Instant& at, std::size_t particles) {
  for (std::size_t i = 0; i < particles; ++i) scratch_[i].prior = at.belief(i);
}

void MappingStep::restore_priors(Instant& at, std::size_t particles) {
  for (std::size_t i = 0; i < particles; ++i) at.belief(i) = scratch_[i].prior;
}

void MappingStep::refine_each(const ParticleSet& particles, Instant& at, std::span<const MappingInput> inputs,
                              Time stamp, std::uint32_t sensor) {
  const auto refine = [&](int slot) {
    const auto i = static_cast<std::size_t>(slot);
    refine_one(i, particles[i], at.belief(i), inputs, stamp, sensor);
  };
  workers_.for_each(static_cast<int>(particles.size()), std::cref(refine), kSerialMapping);
}

/// Lets every map refine `belief` in turn.
void MappingStep::refine_one(std::size_t slot, const Particle& particle, Belief& belief,
                             std::span<const MappingInput> inputs, Time stamp, std::uint32_t sensor) {
  Scratch& scratch = scratch_[slot];
  scratch.log_evidence = 0.0;
  scratch.writes = false;
  scratch.informed = false;
  scratch.failed = false;
  scratch.searched = false;
  scratch.innovation = {};
  scratch.compared = false;
  scratch.failed_input = -1;
  // One per module, so that every module gets its own association back.
  scratch.refinements.resize(particle.maps.size());
  scratch.refined_from.resize(particle.maps.size());
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto& map = particle.maps[static_cast<std::size_t>(inputs[i].module)];
    if (!map) continue;
    try {
      const PoseGaussian prior = pose_of(belief);
      refine_by(inputs[i], *map, prior, draw_start(slot, prior, stamp, sensor), belief, scratch);
    } catch (const std::exception& error) {
      scratch.failed_input = static_cast<int>(i);
      scratch.failure = error.what();
      return;
    } catch (...) {
      scratch.failed_input = static_cast<int>(i);
      scratch.failure = "unknown exception";
      return;
    }
  }
}

/// A draw from the prior, where the search of a map begins.
Pose MappingStep::draw_start(std::size_t slot, const PoseGaussian& prior, Time stamp, std::uint32_t sensor) const {
  Random stream = streams_(static_cast<int>(slot), stamp, kPriorDraw + sensor);
  const Eigen::Vector3d draw = gaussian::sample(prior.P, stream);
  return displaced(prior.T_map_base, draw);
}

void MappingStep::refine_by(const MappingInput& input, const ParticleMap& map, const PoseGaussian& prior,
                            const Pose& start, Belief& belief, Scratch& scratch) const {
  Refinement& refinement = scratch.refinements[static_cast<std::size_t>(input.module)];
  scratch.refined_from[static_cast<std::size_t>(input.module)] = prior.T_map_base;
  refinement.information.setZero();
  refinement.gradient.setZero();
  refinement.log_evidence = 0.0;
  refinement.writes = true;
  refinement.failed = false;
  refinement.searched = false;
  refinement.slip.setZero();
  refinement.spatial.reset();
  refinement.jump.reset();
  map.refine(prior, start, *input.observation, refinement);
  if (input.localize && refinement.jump) refuse_jump(input, map, prior, refinement);
  if (!std::isfinite(refinement.log_evidence)) throw Error("the map's log evidence is not finite");
  scratch.writes = scratch.writes || refinement.writes;
  scratch.compared = scratch.compared || refinement.spatial || refinement.failed;
  if (!input.localize) return;
  if (!add_information(refinement, input.share, belief, scratch.innovation))
    throw Error("the map's pose information is not finite");
  scratch.log_evidence += input.share * refinement.log_evidence;
  scratch.informed = scratch.informed || refinement.spatial || !refinement.information.isZero(0.0);
  scratch.failed = scratch.failed || refinement.failed;
  scratch.searched = scratch.searched || refinement.searched;
}

/// What there is without the match, if the particle may not use it.
void MappingStep::refuse_jump(const MappingInput& input, const ParticleMap& map, const PoseGaussian& prior,
                              Refinement& refinement) const {
  Correspondences correspondences;
  map.correspond(*input.observation, refinement.association.get(), correspondences);
  if (may_jump_(correspondences.points_base, displaced(prior.T_map_base, refinement.jump->d))) return;
  refinement.information = refinement.jump->information;
  refinement.gradient = refinement.jump->gradient;
  refinement.slip.setZero();
  refinement.spatial.reset();
  refinement.log_evidence = refinement.jump->log_evidence;
  refinement.failed = refinement.jump->failed;
  if (refinement.association) refinement.association->refused = true;
}

/// Refines the belief, after a slip the wider one. False if the information is not finite.
bool MappingStep::add_information(const Refinement& refinement, double share, Belief& belief,
                                  MapInnovation& innovation) const {
  if (!refinement.slip.allFinite()) return false;
  if (!refinement.slip.isZero(0.0)) estimation::ekf::add_pose_covariance(belief, layout_, refinement.slip);
  const PoseGaussian prior = pose_of(belief);
  if (!apply(refinement, share, belief)) return false;
  add_innovation(refinement, share, prior, innovation);
  return true;
}

/// False if the information is not finite.
bool MappingStep::apply(const Refinement& refinement, double share, Belief& belief) const {
  if (!refinement.spatial)
    return estimation::ekf::apply_pose_information(belief, layout_, share * refinement.information,
                                                   share * refinement.gradient);
  if (layout_.motion() == StateLayout::Motion::planar)
    throw Error("the map refines height, roll and pitch, which planar motion does not have");
  const auto& [information, gradient] = *refinement.spatial;
  return estimation::ekf::apply_spatial_information(belief, layout_, share * information, share * gradient);
}

PoseGaussian MappingStep::pose_of(const Belief& belief) const {
  PoseGaussian pose{belief.mean.T_map_base, pose_covariance(belief, layout_)};
  if (layout_.motion() == StateLayout::Motion::spatial) pose.P_spatial = spatial_covariance(belief);
  return pose;
}

void MappingStep::weigh(ParticleSet& particles) {
  for (std::size_t i = 0; i < particles.size(); ++i) particles[i].log_weight += scratch_[i].log_evidence;
  const auto half_or_more = [&](bool Scratch::*property) {
    return 2 * std::ranges::count_if(scratch_, property) >= static_cast<std::ptrdiff_t>(particles.size());
  };
  localized_ = half_or_more(&Scratch::informed);
  failed_ = half_or_more(&Scratch::failed);
  searched_ = half_or_more(&Scratch::searched);
  // The particles differ in how many directions are observed: what is reported fits the mean of both.
  double nis = 0.0;
  double dof = 0.0;
  for (const Scratch& scratch : scratch_) {
    nis += scratch.innovation.nis;
    dof += scratch.innovation.dof;
  }
  const double mean_dof = dof / static_cast<double>(particles.size());
  innovation_ = {.nis = 0.0, .dof = static_cast<int>(std::lround(mean_dof))};
  if (innovation_.dof > 0) innovation_.nis = nis * innovation_.dof / dof;
}

void MappingStep::insert_each(ParticleSet& particles, Instant& at, std::span<const MappingInput> inputs,
                              std::size_t input) {
  const auto insert = [&](int slot) {
    const auto i = static_cast<std::size_t>(slot);
    insert_one(i, particles[i], at.belief(i), inputs, input);
  };
  workers_.for_each(static_cast<int>(particles.size()), std::cref(insert), kSerialMapping);
}

void MappingStep::insert_one(std::size_t slot, Particle& particle, const Belief& belief,
                             std::span<const MappingInput> inputs, std::size_t input) {
  Scratch& scratch = scratch_[slot];
  scratch.failed_input = -1;
  const auto module = static_cast<std::size_t>(inputs[input].module);
  const auto& map = particle.maps[module];
  if (!map) return;
  try {
    map->insert(pose_of(belief), *inputs[input].observation, scratch.refinements[module].association.get());
  } catch (const std::exception& error) {
    scratch.failed_input = static_cast<int>(input);
    scratch.failure = error.what();
  } catch (...) {
    scratch.failed_input = static_cast<int>(input);
    scratch.failure = "unknown exception";
  }
}

/// True if this is the first failure of its input.
bool MappingStep::note_failure(const Scratch& scratch, MappingFailures& failures) {
  const auto is_same = [&](const auto& failure) { return failure.first == scratch.failed_input; };
  if (std::ranges::any_of(failures, is_same)) return false;
  failures.emplace_back(scratch.failed_input, scratch.failure);
  return true;
}

}  // namespace waymark::particles
