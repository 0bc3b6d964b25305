// SPDX-License-Identifier: Apache-2.0
#include "particles/particle_filter.hpp"

#include <algorithm>
#include <cassert>
#include <functional>
#include <utility>

namespace waymark::particles {

namespace ekf = estimation::ekf;

namespace {

// Purposes of random streams other than a sensor's.
constexpr std::uint32_t kStartDraw = 0xFFFFFFFF;
constexpr std::uint32_t kResampling = 0x80000000;  // + sensor

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
    const auto sample_one = [&](int slot) {
      const auto i = static_cast<std::size_t>(slot);
      if (!filter_.mapping_.writes(i)) return;
      Random stream = filter_.streams_(slot, filter_.stamp(), sensor);
      ekf::sample_pose(filter_.set_[i].belief, filter_.layout(), filter_.settings_.sampling_fraction, stream);
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
      mapping_(process.layout(), workers_, streams_, set_.size()),
      recollection_(process, set_, moments_, workers_, settings.history),
      joint_(settings.joint.enabled && !modules_.empty()
                 ? std::make_optional<joint::JointBelief>(process, settings.joint)
                 : std::nullopt),
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
  // A single draw cannot represent the prior, so a single particle keeps all of it.
  if (!georeference_ && draw && set_.size() > 1) {
    for (std::size_t slot = 0; slot < set_.size(); ++slot) {
      Random stream = streams_(static_cast<int>(slot), stamp(), kStartDraw);
      ekf::sample_pose(set_[slot].belief, layout(), settings_.sampling_fraction, stream);
    }
  }
  recollection_.past().clear();
  set_.normalize();
  mixture_is_current_ = false;
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
  mixture_is_current_ = false;
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
  if (joint_) {
    joint_->linearize_at(set_[set_.best()].belief.mean);
    joint_->predict(to, standing);
  }
  const auto predict_one = [&](int slot) {
    process_.predict(set_[static_cast<std::size_t>(slot)].belief, to, standing);
  };
  workers_.for_each(static_cast<int>(set_.size()), std::cref(predict_one), kSerialUpdates);
  mixture_is_current_ = false;
}

Instant& ParticleFilter::now() { return *now_; }

Instant* ParticleFilter::recall(Time stamp) { return recollection_.recall(stamp) ? &recollection_ : nullptr; }

MixtureOutcome ParticleFilter::update(Instant& at, const Update& model, const UpdatePolicy& policy) {
  // What is late changes the weights, and no pose.
  const bool is_joint = joint_ && &at == now_.get();
  const std::size_t best = set_.best();
  if (is_joint) joint_->linearize_at(set_[best].belief.mean);
  MixtureOutcome outcome = updates_.apply(set_, at, model, policy);
  if (!outcome.usable) return outcome;
  if (is_joint && outcome.accepted && !policy.evaluate_only)
    joint_->update(updates_.model(best), updates_.jacobian(best));
  set_.normalize();
  mixture_is_current_ = false;
  return outcome;
}

MappingFailures ParticleFilter::map(Instant& at, std::span<const MappingInput> inputs, std::uint32_t sensor) {
  MappingFailures failures;
  const auto drop = [&](int module) { drop_module(module); };
  mapping_.refine(set_, at, inputs, stamp(), sensor, failures, drop);
  set_.normalize();
  mixture_is_current_ = false;
  if (joint_ && &at == now_.get()) map_jointly(inputs, failures);
  at.sample(sensor);
  mapping_.insert(set_, at, inputs, failures, drop);
  ++mapping_steps_;
  at.conclude_mapping(sensor);
  return failures;
}

void ParticleFilter::map_jointly(std::span<const MappingInput> inputs, MappingFailures& failures) {
  const std::size_t slot = set_.best();
  const Particle& best = set_[slot];
  joint_->linearize_at(best.belief.mean);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const MappingInput& input = inputs[i];
    const auto module = static_cast<std::size_t>(input.module);
    const auto& map = best.maps[module];
    if (!map || !input.localize) continue;
    const Refinement& refinement = mapping_.refinement(slot, input.module);
    correspondences_.landmarks.clear();
    correspondences_.points_base.clear();
    try {
      const PoseGaussian pose{best.belief.mean.T_map_base, pose_covariance(best.belief, layout())};
      map->correspond(pose, *input.observation, refinement.association.get(), correspondences_);
    } catch (const std::exception& error) {
      failures.emplace_back(static_cast<int>(i), error.what());
      drop_module(input.module);
      continue;
    }
    joint_->map(
        {input.share * refinement.information, input.share, refinement.writes, modules_[module]->has_prior_map()},
        correspondences_);
  }
}

void ParticleFilter::stop() {
  for (Particle& particle : set_) ekf::stop(particle.belief, layout());
  if (joint_) joint_->replace_twist([&](Belief& belief) { ekf::stop(belief, layout()); });
  mixture_is_current_ = false;
}

void ParticleFilter::release(double velocity_sigma, double rate_sigma) {
  const auto release_one = [&](Belief& belief) { ekf::release(belief, layout(), velocity_sigma, rate_sigma); };
  for (Particle& particle : set_) release_one(particle.belief);
  if (joint_) joint_->replace_twist(release_one);
  mixture_is_current_ = false;
}

void ParticleFilter::inflate_pose(const ekf::PoseVariance& variance) {
  mixture_is_current_ = false;
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
  mixture_is_current_ = false;
}

void ParticleFilter::drop_module(int module) {
  const auto index = static_cast<std::size_t>(module);
  modules_[index] = nullptr;
  for (Particle& particle : set_) {
    if (index < particle.maps.size()) particle.maps[index] = nullptr;
  }
}

const Belief& ParticleFilter::mixture() {
  if (mixture_is_current_) return mixture_;
  for (std::size_t i = 0; i < set_.size(); ++i) beliefs_[i] = &set_[i].belief;
  moments_.compute(beliefs_, set_, mixture_);
  mixture_is_current_ = true;
  return mixture_;
}

const Belief& ParticleFilter::mixture() const {
  assert(mixture_is_current_);
  return mixture_;
}

Belief ParticleFilter::reported() const {
  Belief belief = mixture();
  if (!joint_) return belief;
  Belief joint = joint_->marginal(set_[set_.best()].belief.mean);
  if (georeference_) georeference_->to_enu(joint);
  // Where the particles are of several opinions, their spread is larger.
  const Eigen::Matrix3d own = pose_covariance(joint, layout());
  const Eigen::Matrix3d more = gaussian::excess(pose_covariance(belief, layout()), own);
  belief.P = joint.P;
  const auto& pose = layout().pose_indices();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      belief.P(pose[static_cast<std::size_t>(i)], pose[static_cast<std::size_t>(j)]) += more(i, j);
  }
  return belief;
}

std::optional<Eigen::Matrix2d> ParticleFilter::landmark_covariance(const Eigen::Vector2d& p_map) const {
  if (!joint_) return std::nullopt;
  return joint_->landmark_covariance(p_map, set_[set_.best()].belief.mean, georeference_);
}

}  // namespace waymark::particles
