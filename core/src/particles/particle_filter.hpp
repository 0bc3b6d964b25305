// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estimation/ekf.hpp"
#include "estimation/georeference.hpp"
#include "estimation/new_start.hpp"
#include "estimation/process_model.hpp"
#include "joint/joint_belief.hpp"
#include "loops/loop_closer.hpp"
#include "particles/instant.hpp"
#include "particles/jump_watch.hpp"
#include "particles/mapping_step.hpp"
#include "particles/mixture_moments.hpp"
#include "particles/particle_set.hpp"
#include "particles/recollection.hpp"
#include "particles/redrawing.hpp"
#include "particles/update_step.hpp"
#include "particles/workers.hpp"
#include "relocation/placement.hpp"
#include "relocation/relocator.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/io/archive.hpp"

namespace waymark {
class MapModule;
}

namespace waymark::particles {

/// The Rao-Blackwellized particle filter (T. Emter; FastSLAM 2.0 after M. Montemerlo et al., IJCAI 2003): every
/// particle has its own EKF, its own maps and its own data association. With one particle and no maps it is a plain
/// EKF. The same input gives the same bytes with any number of threads.
class WAYMARK_API ParticleFilter {
 public:
  /// `process` and its layout must outlive the filter. `georeference`: set if the state has the map's place on the
  /// Earth.
  ParticleFilter(const estimation::ProcessModel& process, std::vector<std::shared_ptr<MapModule>> modules,
                 const ParticleFilterSettings& settings,
                 std::optional<estimation::Georeference> georeference = std::nullopt);
  ~ParticleFilter();
  ParticleFilter(const ParticleFilter&) = delete;
  ParticleFilter& operator=(const ParticleFilter&) = delete;

  /// `frame`: covariance of (x, y, yaw) of the start pose that the particles take for the map's origin; it is in the
  /// reported covariance only. Sets all particles to `prior`. If `draw`, each of several particles samples its pose
  /// from it (with the sampling fraction). With a georeference nothing is drawn: the start pose becomes the map's
  /// origin, and the prior that of the georeference. Maps become the modules' initial ones.
  void start(const Belief& prior, bool draw, const Eigen::Matrix3d& frame = Eigen::Matrix3d::Zero());

  /// Begins the belief of every particle anew: the pose is lost, while maps, paths, weights and the own states of
  /// sensors stay. Past beliefs are forgotten.
  void begin_anew(const estimation::NewStart& start);
  /// True if the beliefs of all particles can be updated (`estimation::is_sound`).
  bool is_sound() const;
  /// The same, by a look at the variances alone.
  bool has_plausible_variances() const;

  Time stamp() const { return set_[0].belief.stamp; }
  /// Predicts all particles to `to`, not before `stamp()`. At standstill no noise enters pose and twist.
  void predict(Time to, bool standing);

  /// The present particles.
  Instant& now();
  /// The particles at an earlier time, for a late measurement; valid until the filter changes. Null if no beliefs of
  /// that time are stored.
  Instant* recall(Time stamp);
  /// Stores the present beliefs for `recall`, if a record is due.
  void remember() { recollection_.remember(); }

  /// Applies one measurement model to every particle, gated on the mixture's innovation, and adds the log evidence to
  /// the weights. A gated-out update counts in the weight with its likelihood clamped at the gate. Throws Error if the
  /// model throws.
  MixtureOutcome update(Instant& at, const Update& model, const UpdatePolicy& policy);
  MixtureOutcome update(const Update& model, const UpdatePolicy& policy) { return update(now(), model, policy); }

  /// One mapping step: refine, sample, weigh, insert, resample, with a barrier between. Past particles are not sampled.
  /// Returns the inputs whose modules threw: their part was discarded for all particles and their maps are dropped.
  MappingFailures map(Instant& at, std::span<const MappingInput> inputs, std::uint32_t sensor);
  MappingFailures map(std::span<const MappingInput> inputs, std::uint32_t sensor) { return map(now(), inputs, sensor); }
  /// True if, in the last mapping step, maps gave half of the particles or more information about their pose.
  bool localized() const { return mapping_.localized(); }
  /// True if the observation of the last mapping step did not fit the maps of half of the particles or more.
  bool match_failed() const { return mapping_.failed(); }
  /// True if it contradicted the maps of half of the particles or more where they expected it, even after a search.
  bool match_searched() const { return mapping_.searched(); }
  /// How far the maps' information of the last mapping step lay from the prior.
  const MapInnovation& map_innovation() const { return mapping_.innovation(); }
  /// How many observations of this run may have torn the maps, and no loop relates what was before to what came after:
  /// they fitted nowhere and were written at poses that were uncertain by 1.5 m (σ, of a surface in a distance of 5 m),
  /// or the maps held the robot back for long.
  std::size_t suspected_tears() const { return suspected_tears_.size(); }

  /// Sets velocity and rate to zero, for standstill.
  void stop();
  /// Gives velocity and rate a new, uncorrelated covariance.
  void release(double velocity_sigma, double rate_sigma);
  /// Inflates the pose of every particle, so that measurements can correct a wrong filter. With a georeference it
  /// inflates the position of the map on the Earth instead, since the particles are localized in the map.
  void inflate_pose(const estimation::ekf::PoseVariance& variance);
  /// Appends the present poses to the paths, for hosts without maps.
  void record_path();
  /// Appends the present poses as dead reckoning, which the next mapping step corrects.
  void record_tentative_path();
  /// Resamples if N_eff is below the threshold; `map` does so by itself.
  void resample_if_needed(std::uint32_t sensor);
  /// Takes a module out of service: its maps are dropped.
  void drop_module(int module);

  const ParticleSet& set() const { return set_; }
  const std::vector<Particle>& particles() const { return set_.all(); }
  /// Poses, in ENU where that is known, and weights of the particles.
  void view(std::vector<ParticleView>& views) const;
  const StateLayout& layout() const { return process_.layout(); }
  const std::optional<estimation::Georeference>& georeference() const { return georeference_; }
  /// The map's place on the Earth in this particle; the identity without a georeference.
  Pose T_enu_map(const Particle& particle) const {
    return georeference_ ? georeference_->T_enu_map(particle.belief.mean) : Pose{};
  }
  /// Moments of the mixture, the poses in ENU: weighted mean and covariance; computed if the filter has changed. After
  /// a mapping step, until the next change: of the refined Gaussians *before* sampling, since a sampled pose has no
  /// covariance of its own.
  const Belief& mixture();
  /// The same; the filter must not have changed since the last computation.
  const Belief& mixture() const;
  /// The belief to be reported, the pose in ENU: the mixture's mean, and about it the second moment of the joint
  /// Gaussian, for (x, y, yaw) no less than the mixture's. The mixture, if there is no joint Gaussian. Computed if the
  /// filter has changed.
  const Belief& reported();
  /// The same; the filter must not have changed since the last computation.
  const Belief& reported() const;
  /// The landmark of this birth as the joint Gaussian has it, in ENU; nothing if it is not one of its nodes.
  std::optional<joint::JointBelief::LandmarkEstimate> landmark(std::uint64_t birth) const;
  /// Why the joint Gaussian was given up or has begun anew, at the mapping step at which it did.
  joint::JointBelief::Failure take_joint_failure() { return std::exchange(joint_failure_, {}); }
  /// True from then on: what is reported is the particles' covariance alone, which is too small.
  bool gave_up_joint() const { return uses_joint_ && !joint_; }
  /// The loop that the last mapping step closed, if it moved the maps.
  struct ClosedLoop {
    double way;    ///< of the loop [m]
    double shift;  ///< of a place, at most [m]
  };
  /// True once: the path has become too long for loops, which were given up.
  bool take_loops_failure() { return std::exchange(loops_failure_, false); }
  std::optional<ClosedLoop> take_closed_loop() { return std::exchange(closed_loop_, std::nullopt); }
  /// Carries out at once what is left of the correction by a loop, if one is under way.
  void finish_correction();
  /// Of a particle; while a correction is carried out, those before it. The particle's own then show what was seen
  /// last.
  const ParticleMaps& whole_maps(const Particle& particle) const;
  /// True if places that must be those of before do not look so: the maps may be torn.
  bool fails_to_recognise() const { return loops_ && loops_->fails_to_recognise(); }
  /// True while what the robot observes does not fit the loaded map where it is believed to be.
  bool is_misplaced() const { return relocator_ && relocator_->is_lost(); }
  /// What the robot observes, against the loaded map.
  relocation::Placement placement() const;
  /// True if the last mapping step has found the robot elsewhere in the loaded map.
  bool has_place() const { return place_.has_value(); }
  /// That place, once.
  std::optional<relocation::Place> take_place() { return std::exchange(place_, std::nullopt); }
  /// True while there is a loaded map that can be searched.
  bool relocates() const { return relocator_.has_value(); }
  /// Why the loaded map cannot be searched, once; empty if it can.
  std::string take_relocation_failure() { return std::exchange(relocation_failure_, {}); }
  double effective_sample_size() const { return set_.effective_sample_size(); }
  std::uint64_t resamplings() const { return resamplings_; }
  std::uint64_t mapping_steps() const { return mapping_steps_; }

  /// State of the particles, for rollbacks: poses, weights, paths, maps as handles.
  struct State {
    std::vector<Particle> particles;
    std::uint64_t resamplings = 0;
    std::uint64_t mapping_steps = 0;
    std::vector<Time> suspected_tears;
    JumpWatch jumps;
  };
  State state() const;
  /// Sets the particles to `state`; clears the stored beliefs.
  void restore(const State& state);
  /// The filter on a checkpoint. Reading throws DataError if it is of another configuration.
  void save(OutArchive& out) const;
  void load(InArchive& in);
  /// A state to roll back to on a checkpoint; the same.
  template <class Archive>
  void serialize(Archive& archive, State& state) const;

 private:
  template <class Archive>
  void serialize_rest(Archive& archive);
  template <class Archive>
  void serialize_redrawing(Archive& archive);

  /// Passes a mapping step to the joint Gaussian, before the poses are sampled.
  void map_jointly(std::span<const MappingInput> inputs, MappingFailures& failures);
  /// Adds what a particle's map found in the refinement of an input to `correspondences_`. False if its module is out
  /// of service, which one that throws is from now on.
  bool correspond(std::span<const MappingInput> inputs, std::size_t input, std::size_t slot, MappingFailures& failures);
  /// Keeps a mapping step for loops; `slot`: the particle that was the best before sampling.
  void keep_keyframe(std::span<const MappingInput> inputs, std::size_t slot, MappingFailures& failures);
  /// Searches for a loop, or goes on with the correction by one that was found.
  void close_loops();
  void search_loop();
  void give_up_loops();
  void go_on_drawing();
  /// Replaces all particles by this one, of weight 1.
  void become(Particle& only);
  /// Replaces all particles by the best one with the corrected path, in the maps that were drawn along it.
  void take_corrected_maps();
  bool can_close_loops() const;
  /// False for a match that is not expected, in a place that is met again and may lie elsewhere.
  bool may_jump(std::span<const Eigen::Vector2d> points_base, const Pose& T_map_base) const;
  /// Way on which a place counts as met again, if the graph of loops verifies that [m].
  std::optional<double> return_way() const;
  /// True if the graph of loops has all that the joint Gaussian has of the pose.
  bool has_graph() const { return !georeference_ && layout().motion() == StateLayout::Motion::planar; }
  /// The first keyframe with this anchor.
  std::optional<std::size_t> keyframe_of(joint::JointGaussian::NodeId anchor) const;
  /// Moves a particle's anchors as their keyframes were moved from `before`.
  void carry_anchors(Particle& particle, std::span<const Eigen::Vector3d> before);
  /// The joint Gaussian gets the places of the best particle's map anew, and what the graph of the path says.
  void draw_joint_again(const Particle& best);
  /// Suspects a tear where the last mapping step fitted nowhere, at an uncertain pose, or where matches and motion
  /// contradict each other; `slot`: the particle that was the best before sampling.
  void suspect_tear(std::size_t slot);
  /// Adds the match of the last mapping step to `jumps_`.
  void watch_jump(std::span<const MappingInput> inputs, std::size_t slot);
  /// Prepares the search in a loaded map.
  void begin_relocation();
  /// Passes a mapping step to it, before the poses are sampled; `slot`: the best particle.
  void relocate(std::span<const MappingInput> inputs, std::size_t slot, MappingFailures& failures);
  /// The poses were set anew: dead reckoning between mapping steps counts from here.
  void begin_way();
  /// Every particle keeps where it writes what belongs to the anchors that were added.
  void keep_new_anchors();

  /// The only particle is the mixture: no maps sample its pose, and no georeference moves it.
  bool is_one_gaussian() const;
  /// What is reported must be computed anew.
  void has_changed() { mixture_is_current_ = reported_is_current_ = false; }
  /// Thins the older half of paths that have grown too long.
  void bound_paths();

  class Present;

  const estimation::ProcessModel& process_;
  std::vector<std::shared_ptr<MapModule>> modules_;
  ParticleFilterSettings settings_;
  std::optional<estimation::Georeference> georeference_;
  Workers workers_;
  RandomStreams streams_;
  ParticleSet set_;
  MixtureMoments moments_;
  UpdateStep updates_;
  MappingStep mapping_;
  Recollection recollection_;
  bool uses_joint_;                          // with maps only
  std::optional<joint::JointBelief> joint_;  // until it is given up
  joint::JointBelief::Failure joint_failure_;
  std::optional<loops::LoopCloser> loops_;  // where maps can be drawn again
  Path followed_;                           // by its keyframes, at the last search
  std::optional<Redrawing> redrawing_;      // of a correction that is not yet in force
  std::optional<ClosedLoop> closed_loop_;
  bool loops_failure_ = false;
  std::optional<relocation::Relocator> relocator_;  // where a dense map was loaded
  int searched_module_ = -1;                        // of that map
  std::optional<relocation::Place> place_;
  std::string relocation_failure_;
  Eigen::Vector3d moved_ = Eigen::Vector3d::Zero();        // by dead reckoning, since the last step of that map
  Correspondences correspondences_;                        // scratch
  std::vector<joint::JointGaussian::NodeId> new_anchors_;  // of the mapping step
  bool is_spatial_ = false;                                // a map matches all six of the pose
  std::unique_ptr<Present> now_;
  Belief mixture_;
  bool mixture_is_current_ = false;
  Belief reported_;
  bool reported_is_current_ = false;
  std::vector<const Belief*> beliefs_;  // scratch of mixture(): one per slot
  std::uint64_t resamplings_ = 0;
  std::uint64_t mapping_steps_ = 0;
  std::vector<Time> suspected_tears_;
  JumpWatch jumps_;
};

}  // namespace waymark::particles
