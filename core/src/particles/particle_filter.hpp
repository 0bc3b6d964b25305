// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estimation/ekf.hpp"
#include "estimation/georeference.hpp"
#include "estimation/process_model.hpp"
#include "particles/past_beliefs.hpp"
#include "particles/path.hpp"
#include "particles/workers.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::particles {

/// One hypothesis: a navigation EKF, one map per module, a weight, the way it came. Copying it copies handles.
struct Particle {
  Belief belief;
  double log_weight = 0.0;
  std::vector<std::unique_ptr<ParticleMap>> maps;  ///< null where the module is out of service
  Path path;

  Particle clone() const;
};

/// Gates by the number of rows: the χ² quantile of one probability, found once, since the quantile costs more than an
/// update.
class WAYMARK_API Gates {
 public:
  explicit Gates(double probability);
  double operator[](int rows) const { return quantiles_[static_cast<std::size_t>(rows)]; }

 private:
  std::array<double, kMaxUpdateRows + 1> quantiles_{};
};

/// How one update of one sensor enters.
struct UpdatePolicy {
  int owner = 0;  ///< the sensor's place in the layout
  Gates gates{0.999};
  double weight_exponent = 1.0;  ///< on the evidence only
  bool ignore_gate = false;      ///< re-acquisition
  bool absolute = false;         ///< the sensor speaks of the pose in ENU, so its update goes through the georeference
};

/// What the mixture made of one update.
struct MixtureOutcome {
  gaussian::Vector innovation;
  gaussian::Matrix S;
  double nis = 0.0;
  bool accepted = false;
  bool usable = true;  ///< false: a particle's innovation was not finite; nothing was applied
};

/// One module's part in a mapping step.
struct MappingInput {
  int module = 0;
  const Observation* observation = nullptr;
  double share = 1.0;    ///< the likelihood's exponent: information and evidence alike
  bool localize = true;  ///< false: only maps
};

/// The Rao-Blackwellized particle filter (T. Emter; FastSLAM 2.0 after M. Montemerlo et al., IJCAI 2003): every
/// particle has its own EKF, its own maps and its own data association. With one particle and no maps it is a plain
/// EKF. The same input gives the same bytes with any number of threads.
class WAYMARK_API ParticleFilter {
 public:
  /// `process` and its layout must outlive the filter. `georeference`: the map's place on the Earth is in the state.
  ParticleFilter(const estimation::ProcessModel& process, std::vector<std::shared_ptr<MapModule>> modules,
                 const ParticleFilterSettings& settings,
                 std::optional<estimation::Georeference> georeference = std::nullopt);

  /// Sets all particles to `prior`; if `draw`, each of several draws its pose from it (with the sampling fraction), and
  /// one alone keeps it whole. With a georeference nothing is drawn: the start pose is the map's origin, and the prior
  /// becomes the georeference's. Maps become empty.
  void start(const Belief& prior, bool draw);

  Time stamp() const { return particles_.front().belief.stamp; }
  void predict(Time to, bool standing);
  /// Applies one measurement model to every particle, gated on the mixture's innovation, and adds the log evidence to
  /// the weights. A gated-out update counts in the weight with its likelihood clamped at the gate.
  MixtureOutcome update(const Update& model, const UpdatePolicy& policy);
  void stop();
  void release(double velocity_sigma, double rate_sigma);
  /// Adds variance to x, y and yaw of every particle, so that a filter that lost its way can be found again; with a
  /// georeference to the map's place on the Earth, since the particles know their way in the map.
  void inflate_pose(double position_variance, double yaw_variance);

  /// One mapping step at `stamp()`: refine, sample and weigh, insert, resample, with a barrier between.
  /// Returns the indices (into `inputs`) of modules that threw, with the message: their part was discarded for all
  /// particles and their maps are gone.
  std::vector<std::pair<int, std::string>> map(std::span<const MappingInput> inputs, std::uint32_t sensor);

  /// True if, in the last mapping step, maps told half of the particles or more something about their pose.
  bool located() const { return located_; }

  // Late data. The sampled paths and the maps stay as they are (estimation.md §2, "Order"): a measurement that the
  // proposals did not use weighs the particles, and tells of those states that are Gaussian given the path.

  /// Keeps the present beliefs for late measurements, if it is time for it.
  void remember();
  /// Goes back, for the calls that follow, to what every particle believes of `stamp` <= `stamp()`. False if that is
  /// forgotten.
  bool recall(Time stamp);
  /// Moments of the mixture at the recalled time, the poses in ENU.
  const Belief& recalled_mixture() const { return recalled_mixture_; }
  /// `update` for a measurement of the recalled time: adds the log evidence to the weights, and updates the blocks
  /// through their cross-covariance with the past state. Poses stay. `recall` again before the next one.
  MixtureOutcome update_late(const Update& model, const UpdatePolicy& policy);
  /// `map` for a measurement of the recalled time: weighs, and inserts where each particle was, without a new sample.
  std::vector<std::pair<int, std::string>> map_late(std::span<const MappingInput> inputs, std::uint32_t sensor);

  /// What the particles are, to go back to: poses, weights, paths, maps as handles.
  struct State {
    std::vector<Particle> particles;
    std::uint64_t resamplings = 0;
    std::uint64_t mapping_steps = 0;
  };
  State state() const;
  void restore(const State& state);

  /// Resamples if N_eff is below the threshold; `map` does so by itself.
  void resample_if_needed(std::uint32_t sensor);
  /// Appends the present poses to the paths, for hosts without maps.
  void record_path();
  /// Appends them as dead reckoning, which the next mapping step corrects.
  void record_tentative_path();
  /// Takes a module out of service: its maps are dropped.
  void drop_module(int module);

  const std::vector<Particle>& particles() const { return particles_; }
  const StateLayout& layout() const { return process_.layout(); }
  /// Where this particle has the map on the Earth; the identity without a georeference.
  Pose T_enu_map(const Particle& particle) const {
    return georeference_ ? georeference_->T_enu_map(particle.belief.mean) : Pose{};
  }
  const std::optional<estimation::Georeference>& georeference() const { return georeference_; }
  /// Moments of the mixture, the poses in ENU: weighted mean (circular for the attitude) and covariance within plus
  /// between particles. After a mapping step, until the next change: of the refined Gaussians *before* sampling, since
  /// a sampled pose has no covariance of its own.
  const Belief& mixture() const;
  double effective_sample_size() const;
  int best() const;  ///< the particle with the highest weight; the first of equals
  std::uint64_t resamplings() const { return resamplings_; }
  std::uint64_t mapping_steps() const { return mapping_steps_; }

  void save(OutArchive& out) const;
  void load(InArchive& in);
  void save(const State& state, OutArchive& out) const;
  State load_state(InArchive& in) const;

 private:
  struct Scratch {  // per slot, kept between calls so that warm steps do not allocate
    Linearization model;
    estimation::ekf::Innovation innovation;
    Belief prior;  // before refinement, to start over when a module fails
    NavState enu;  // the mean with its pose in ENU
    std::vector<Refinement> refinements;
    Belief recalled;           // at the time of a late measurement
    ErrorMatrix now_and_then;  // Cov(state now, state then), given all that came between
    double log_evidence = 0.0;
    bool writes = false;  // some map will write where the pose says
    bool told = false;    // some map told something about the pose
    std::string failure;
    int failed_input = -1;
  };

  /// Weighted sums over some particles, relative to a center.
  struct Moments {
    ErrorVector mean;
    ErrorMatrix P;  ///< within and between the particles
    double widest_turn = 0.0;
    Belief enu;  ///< scratch
  };

  // Below this many particles one EKF update is done sooner than a second thread wakes up.
  static constexpr int kSerialUpdates = 16;

  Random random(int slot, std::uint32_t purpose) const;
  template <class Body>
  void for_each_particle(const Body& body);
  void normalize();
  void compute_mixture() const;
  void compute_moments(std::span<const Belief* const> beliefs, Belief& mixture) const;
  void sum_moments(std::size_t chunk, std::span<const Belief* const> beliefs, const NavState& center) const;
  void innovate(int slot, const Belief& belief, const Update& model, const UpdatePolicy& policy, bool late);
  MixtureOutcome weigh_and_apply(const UpdatePolicy& policy);
  void recall(int slot, const Belief& record, Time stamp);
  void refine(int slot, Belief& belief, std::span<const MappingInput> inputs, std::uint32_t sensor);
  void refine_all(std::span<const MappingInput> inputs, std::uint32_t sensor, bool late,
                  std::vector<std::pair<int, std::string>>& failures);
  void insert(int slot, const Belief& belief, std::span<const MappingInput> inputs, std::size_t input);
  void insert_all(std::span<const MappingInput> inputs, bool late, std::vector<std::pair<int, std::string>>& failures);
  bool collect_failures(std::span<const MappingInput> inputs, std::vector<std::pair<int, std::string>>& failures);

  const estimation::ProcessModel& process_;
  std::vector<std::shared_ptr<MapModule>> modules_;
  ParticleFilterSettings settings_;
  std::optional<estimation::Georeference> georeference_;
  mutable Workers workers_;
  std::vector<Particle> particles_;
  std::vector<Scratch> scratch_;
  std::vector<double> log_weights_;
  mutable std::vector<Moments> moments_;
  mutable Belief mixture_;
  mutable bool mixture_valid_ = false;
  PastBeliefs past_;
  mutable std::vector<const Belief*> beliefs_;  // scratch: one per slot
  Belief recalled_mixture_;
  std::uint64_t resamplings_ = 0;
  std::uint64_t mapping_steps_ = 0;
  bool located_ = false;
};

}  // namespace waymark::particles
