// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "joint/anchors.hpp"
#include "particles/path.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/memory/lineage.hpp"

namespace waymark::particles {

/// One hypothesis: a navigation EKF, a weight, one map per module, the trajectory. Copying it copies handles.
struct Particle {
  Belief belief;
  double log_weight = 0.0;
  std::vector<std::unique_ptr<ParticleMap>> maps;  ///< null where the module is out of service
  Path path;
  Lineage<joint::AnchorPose> anchors;  ///< where it was when anchors of the joint Gaussian were added
  Pose T_map_mapped;                   ///< of the base after its last mapping step

  /// A copy; maps as handles.
  Particle clone() const;
};

/// Gates by the number of rows: the χ² quantile of one probability, computed once, since it costs more than an update.
class WAYMARK_API Gates {
 public:
  explicit Gates(double probability);
  double operator[](int rows) const { return quantiles_[static_cast<std::size_t>(rows)]; }

 private:
  std::array<double, kMaxUpdateRows + 1> quantiles_{};
};

/// How the updates of one sensor are applied.
struct UpdatePolicy {
  int owner = 0;  ///< the sensor's place in the layout
  Gates gates{0.999};
  double weight_exponent = 1.0;  ///< on the evidence only
  bool ignore_gate = false;      ///< re-acquisition
  bool absolute = false;         ///< the model has the pose in ENU, so its update needs the georeference
  bool evaluate_only = false;    ///< innovation and gate only; nothing is applied or weighed
};

/// The result of one update for the mixture.
struct MixtureOutcome {
  gaussian::Vector innovation;
  gaussian::Matrix S;
  double nis = 0.0;
  bool accepted = false;
  bool usable = true;           ///< false: a particle's innovation was not finite; nothing was applied
  bool observes_speed = false;  ///< the model depends on how fast the base moves forwards
};

/// One module's part in a mapping step.
struct MappingInput {
  int module = 0;
  const Observation* observation = nullptr;
  double share = 1.0;                                 ///< the likelihood's exponent: information and evidence alike
  bool localize = true;                               ///< false: the module only maps
  std::shared_ptr<const Observation> kept = nullptr;  ///< the observation, if a loop may draw the maps again
};

/// Indices into the inputs of a mapping step whose modules threw, with the message.
using MappingFailures = std::vector<std::pair<int, std::string>>;

}  // namespace waymark::particles
