// SPDX-License-Identifier: Apache-2.0
#include "particles/particle_filter.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

#include "waymark/interface/map_module.hpp"

namespace waymark::particles {

namespace ekf = estimation::ekf;

namespace {

// Purposes of random streams other than a sensor's.
constexpr std::uint32_t kStartDraw = 0xFFFFFFFF;
constexpr std::uint32_t kResampling = 0x80000000;  // + sensor

/// What a match says about all six of the pose, as the particle used it.
std::optional<joint::SpatialMatch> scaled(const std::optional<SpatialInformation>& about, double share,
                                          const Pose& prior) {
  if (!about) return std::nullopt;
  return joint::SpatialMatch{prior, {share * about->information, share * about->gradient}};
}

}  // namespace

/// The particles now.
class ParticleFilter::Present final : public Instant {
 public:
  explicit Present(ParticleFilter& filter) : filter_(filter) {}

  Belief& belief(std::size_t slot) override { return filter_.set_[slot].belief; }
  const Belief& mixture() override { return filter_.mixture(); }
  void carry_gain(std::size_t, const estimation::StateJacobian&, ekf::Innovation&) override {}

  /// The reported moments are those of the refined mixture before it is sampled.
  void sample(std::uint32_t sensor) override {
    filter_.mixture();
    // Draws would shift and turn the particles' maps against each other, and the few that are left in the end with
    // them.
    const bool begins_maps =
        filter_.is_spatial_ && filter_.settings_.maps_begin_anywhere && filter_.mapping_steps_ == 0;
    const auto sample_one = [&](int slot) {
      const auto i = static_cast<std::size_t>(slot);
      if (!filter_.mapping_.writes(i)) return;
      Belief& belief = filter_.set_[i].belief;
      const double fraction = filter_.settings_.sampling_fraction;
      if (begins_maps) return ekf::take_spatial_pose(belief, filter_.layout(), fraction);
      // A single draw would only move its map; with 1 it is FastSLAM as published.
      if (filter_.set_.size() == 1 && fraction < 1.0) {
        const auto take = filter_.is_spatial_ ? ekf::take_spatial_pose : ekf::take_pose;
        return take(belief, filter_.layout(), fraction);
      }
      Random stream = filter_.streams_(slot, filter_.stamp(), sensor);
      const auto spatial =
          filter_.mapping_.begins_spatial_map(i) ? ekf::sample_first_spatial_pose : ekf::sample_spatial_pose;
      const auto sample = filter_.is_spatial_ ? spatial : ekf::sample_pose;
      sample(belief, filter_.layout(), fraction, stream);
    };
    filter_.workers_.for_each(static_cast<int>(filter_.set_.size()), std::cref(sample_one), kSerialUpdates);
  }

  void conclude_mapping(std::uint32_t sensor) override {
    for (std::size_t i = 0; i < filter_.set_.size(); ++i) {
      Particle& particle = filter_.set_[i];
      particle.path.distribute_correction(filter_.mapping_.prior(i).mean.T_map_base, particle.belief.mean.T_map_base);
    }
    filter_.record_path();
    filter_.resample_if_needed(sensor);
    filter_.mixture_is_current_ = true;
  }

 private:
  ParticleFilter& filter_;
};

ParticleFilter::ParticleFilter(const estimation::ProcessModel& process, std::vector<std::shared_ptr<MapModule>> modules,
                               const ParticleFilterSettings& settings,
                               std::optional<estimation::Georeference> georeference)
    : process_(process),
      modules_(std::move(modules)),
      settings_(settings),
      georeference_(georeference),
      workers_(settings.threads),
      streams_{settings.seed},
      set_(settings.particles),
      moments_(process.layout(), georeference_, workers_, set_.size()),
      updates_(process.layout(), georeference_, workers_, set_.size()),
      mapping_(process.layout(), workers_, streams_, set_.size(),
               [this](std::span<const Eigen::Vector2d> points, const Pose& pose) { return may_jump(points, pose); }),
      recollection_(process, set_, moments_, workers_, settings.history),
      uses_joint_(settings.joint.enabled && !modules_.empty()),
      joint_(uses_joint_ ? std::make_optional<joint::JointBelief>(process, settings.joint, return_way())
                         : std::nullopt),
      loops_(can_close_loops() ? std::make_optional<loops::LoopCloser>(settings.loops, settings.joint) : std::nullopt),
      is_spatial_(std::ranges::any_of(modules_, [](const auto& module) { return module && module->is_spatial(); })),
      now_(std::make_unique<Present>(*this)),
      beliefs_(set_.size()) {
  assert(settings.particles >= 1);
}

ParticleFilter::~ParticleFilter() = default;

void ParticleFilter::start(const Belief& prior, bool draw, const Eigen::Matrix3d& frame) {
  for (Particle& particle : set_) {
    particle = Particle{};
    particle.belief = prior;
    for (const auto& module : modules_) particle.maps.push_back(module ? module->create_map() : nullptr);
  }
  if (georeference_) {
    for (Particle& particle : set_) georeference_->take_over_start(particle.belief);
  }
  if (joint_) joint_->start(set_[0].belief, frame);
  if (loops_) loops_->clear();
  followed_ = {};
  redrawing_.reset();
  suspected_tears_.clear();
  jumps_ = {};
  begin_relocation();
  // A single draw cannot represent the prior, so a single particle keeps all of it.
  if (!georeference_ && draw && set_.size() > 1) {
    for (std::size_t slot = 0; slot < set_.size(); ++slot) {
      Random stream = streams_(static_cast<int>(slot), stamp(), kStartDraw);
      ekf::sample_pose(set_[slot].belief, layout(), settings_.sampling_fraction, stream);
    }
  }
  recollection_.past().clear();
  set_.normalize();
  has_changed();
  begin_way();
}

void ParticleFilter::begin_anew(const estimation::NewStart& start) {
  for (Particle& particle : set_) {
    // Dead reckoning before the gap is not corrected by what is found after it.
    const Pose last = particle.belief.mean.T_map_base;
    particle.path.distribute_correction(last, last);
    estimation::begin_anew(particle.belief, start, layout(), georeference_);
  }
  if (joint_) joint_->restart(set_[set_.best()].belief);
  recollection_.past().clear();
  set_.normalize();
  has_changed();
  begin_way();
}

bool ParticleFilter::is_sound() const {
  return std::ranges::all_of(set_.all(),
                             [](const Particle& particle) { return estimation::is_sound(particle.belief); });
}

bool ParticleFilter::has_plausible_variances() const {
  return std::ranges::all_of(
      set_.all(), [](const Particle& particle) { return estimation::has_plausible_variances(particle.belief); });
}

void ParticleFilter::predict(Time to, bool standing) {
  if (to == stamp()) return;
  if (joint_) joint_->predict(to, standing);
  const auto predict_one = [&](int slot) {
    process_.predict(set_[static_cast<std::size_t>(slot)].belief, to, standing);
  };
  workers_.for_each(static_cast<int>(set_.size()), std::cref(predict_one), kSerialUpdates);
  has_changed();
}

Instant& ParticleFilter::now() { return *now_; }

Instant* ParticleFilter::recall(Time stamp) { return recollection_.recall(stamp) ? &recollection_ : nullptr; }

MixtureOutcome ParticleFilter::update(Instant& at, const Update& model, const UpdatePolicy& policy) {
  MixtureOutcome outcome = updates_.apply(set_, at, model, policy);
  if (!outcome.usable) return outcome;
  // What is late changes the weights, and no pose.
  if (joint_ && &at == now_.get() && outcome.accepted && !policy.evaluate_only)
    joint_->update(model, policy.owner, georeference_ && policy.absolute ? &*georeference_ : nullptr);
  set_.normalize();
  has_changed();
  return outcome;
}

MappingFailures ParticleFilter::map(Instant& at, std::span<const MappingInput> inputs, std::uint32_t sensor) {
  MappingFailures failures;
  const auto drop = [&](int module) { drop_module(module); };
  const bool is_now = &at == now_.get();
  if (is_now) place_.reset();
  mapping_.refine(set_, at, inputs, stamp(), sensor, failures, drop);
  set_.normalize();
  has_changed();
  if (joint_ && &at == now_.get()) map_jointly(inputs, failures);
  const std::size_t best = set_.best();
  if (is_now) watch_jump(inputs, best);
  const bool keeps = loops_ && &at == now_.get() && mapping_.writes(best);
  if (keeps) keep_keyframe(inputs, best, failures);
  if (is_now && relocator_) relocate(inputs, best, failures);
  at.sample(sensor);
  keep_new_anchors();
  // Scans that were taken elsewhere would spoil the map.
  if (!is_misplaced() && !place_) {
    mapping_.insert(set_, at, inputs, failures, drop);
    if (is_now) suspect_tear(best);
  }
  ++mapping_steps_;
  at.conclude_mapping(sensor);
  if (is_now) {
    for (Particle& particle : set_) particle.T_map_mapped = particle.belief.mean.T_map_base;
  }
  if (keeps) close_loops();
  return failures;
}

void ParticleFilter::map_jointly(std::span<const MappingInput> inputs, MappingFailures& failures) {
  const std::size_t slot = set_.best();
  const Particle& best = set_[slot];
  const std::vector<joint::AnchorPose> anchors = best.anchors.items();
  new_anchors_.clear();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const MappingInput& input = inputs[i];
    const auto module = static_cast<std::size_t>(input.module);
    if (!input.localize) continue;
    const Refinement& refinement = mapping_.refinement(slot, input.module);
    correspondences_.landmarks.clear();
    correspondences_.points_base.clear();
    if (!correspond(inputs, i, slot, failures)) continue;
    if (!refinement.slip.isZero(0.0))
      joint_->add_noise([&](Belief& belief) { ekf::add_pose_covariance(belief, layout(), refinement.slip); });
    const Pose& from = mapping_.refined_from(slot, input.module);
    const joint::PoseMatch match{
        {from.p.x(), from.p.y(), from.yaw()}, input.share * refinement.information, input.share * refinement.gradient};
    const joint::MapEvidence evidence{match,
                                      best.belief.mean.T_map_base,
                                      input.share,
                                      refinement.writes,
                                      modules_[module]->has_prior_map(),
                                      modules_[module]->is_spatial(),
                                      scaled(refinement.spatial, input.share, from)};
    if (const auto added = joint_->map(evidence, correspondences_, anchors)) new_anchors_.push_back(*added);
  }
  joint_failure_ = joint_->check(best.belief);
  if (!joint_failure_.why.empty() && !joint_failure_.has_begun_anew) joint_.reset();
}

bool ParticleFilter::correspond(std::span<const MappingInput> inputs, std::size_t input, std::size_t slot,
                                MappingFailures& failures) {
  const int module = inputs[input].module;
  const auto& map = set_[slot].maps[static_cast<std::size_t>(module)];
  if (!map) return false;
  try {
    map->correspond(*inputs[input].observation, mapping_.refinement(slot, module).association.get(), correspondences_);
  } catch (const std::exception& error) {
    failures.emplace_back(static_cast<int>(input), error.what());
    drop_module(module);
    return false;
  }
  return true;
}

void ParticleFilter::keep_new_anchors() {
  for (const joint::JointGaussian::NodeId anchor : new_anchors_) {
    for (Particle& particle : set_) {
      const Pose& pose = particle.belief.mean.T_map_base;
      particle.anchors.append({anchor, {pose.p.x(), pose.p.y(), pose.yaw()}});
    }
  }
  new_anchors_.clear();
}

void ParticleFilter::stop() {
  for (Particle& particle : set_) ekf::stop(particle.belief, layout());
  if (joint_) joint_->replace_twist([&](Belief& belief) { ekf::stop(belief, layout()); });
  has_changed();
}

void ParticleFilter::release(double velocity_sigma, double rate_sigma) {
  const auto release_one = [&](Belief& belief) { ekf::release(belief, layout(), velocity_sigma, rate_sigma); };
  for (Particle& particle : set_) release_one(particle.belief);
  if (joint_) joint_->replace_twist(release_one);
  has_changed();
}

void ParticleFilter::inflate_pose(const ekf::PoseVariance& variance) {
  has_changed();
  // With a georeference only the position is inflated: a rotation about the map's origin would displace a distant
  // robot.
  const auto inflate = [&](Belief& belief) {
    if (georeference_) {
      georeference_->inflate(belief, variance.position, 0.0);
    } else {
      ekf::inflate_pose(belief, layout(), variance);
    }
  };
  for (Particle& particle : set_) inflate(particle.belief);
  if (joint_) joint_->add_noise(inflate);
}

void ParticleFilter::record_path() {
  for (Particle& particle : set_) particle.path.append(particle.belief.stamp, particle.belief.mean.T_map_base);
  bound_paths();
}

void ParticleFilter::record_tentative_path() {
  for (Particle& particle : set_)
    particle.path.append_tentative(particle.belief.stamp, particle.belief.mean.T_map_base);
  bound_paths();
}

void ParticleFilter::bound_paths() {
  const auto is_long = [this](const Particle& particle) { return particle.path.size() > settings_.path_poses; };
  if (std::ranges::none_of(set_.all(), is_long)) return;
  std::vector<Path*> paths;
  for (Particle& particle : set_) {
    if (particle.path.size() > settings_.path_poses / 2) paths.push_back(&particle.path);
  }
  Path::thin(paths, settings_.path_poses / 2);
}

void ParticleFilter::resample_if_needed(std::uint32_t sensor) {
  const double count = static_cast<double>(set_.size());
  if (set_.size() < 2 || set_.effective_sample_size() >= settings_.resample_threshold * count) return;
  recollection_.past().resampled(set_.resample(streams_(-1, stamp(), kResampling + sensor).uniform()));
  ++resamplings_;
  has_changed();
}

void ParticleFilter::drop_module(int module) {
  const auto index = static_cast<std::size_t>(module);
  modules_[index] = nullptr;
  if (module == searched_module_) relocator_.reset();
  if (redrawing_) redrawing_->drop_module(index);
  for (Particle& particle : set_) {
    if (index < particle.maps.size()) particle.maps[index] = nullptr;
  }
}

bool ParticleFilter::is_one_gaussian() const { return set_.size() == 1 && modules_.empty() && !georeference_; }

const Belief& ParticleFilter::mixture() {
  if (is_one_gaussian()) return set_[0].belief;
  if (mixture_is_current_) return mixture_;
  for (std::size_t i = 0; i < set_.size(); ++i) beliefs_[i] = &set_[i].belief;
  moments_.compute(beliefs_, set_, mixture_);
  mixture_is_current_ = true;
  return mixture_;
}

const Belief& ParticleFilter::mixture() const {
  if (is_one_gaussian()) return set_[0].belief;
  assert(mixture_is_current_);
  return mixture_;
}

const Belief& ParticleFilter::reported() {
  const Belief& particles = mixture();
  if (!joint_) return particles;
  if (reported_is_current_) return reported_;
  reported_ = joint_->belief();
  if (georeference_) georeference_->to_enu(reported_);
  // The second moment about the particles' mean, which their maps belong to.
  const ErrorVector off = boxminus(particles.mean, reported_.mean, layout());
  reported_.P += off * off.transpose();
  reported_.mean = particles.mean;
  // Where the particles are of several opinions, their spread is larger.
  const Eigen::Matrix3d own = pose_covariance(reported_, layout());
  ekf::add_pose_covariance(reported_, layout(), gaussian::excess(pose_covariance(particles, layout()), own));
  reported_is_current_ = true;
  return reported_;
}

const Belief& ParticleFilter::reported() const {
  if (is_one_gaussian()) return set_[0].belief;
  assert(mixture_is_current_ && (!joint_ || reported_is_current_));
  return joint_ ? reported_ : mixture_;
}

std::optional<joint::JointBelief::LandmarkEstimate> ParticleFilter::landmark(std::uint64_t birth) const {
  if (!joint_) return std::nullopt;
  return joint_->landmark(birth, georeference_ ? &*georeference_ : nullptr);
}

void ParticleFilter::view(std::vector<ParticleView>& views) const {
  views.clear();
  views.reserve(set_.size());
  for (const Particle& particle : set_.all())
    views.push_back({T_enu_map(particle) * particle.belief.mean.T_map_base, std::exp(particle.log_weight)});
}

}  // namespace waymark::particles
