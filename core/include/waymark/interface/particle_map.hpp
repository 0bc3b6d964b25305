// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "waymark/interface/map_view.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/math/pose.hpp"

/// One particle's map, and what it exchanges with the filter; the module of which it is: map_module.hpp.
namespace waymark {

/// A Gaussian over the planar part (x, y, yaw) of a base pose; z, roll and pitch are those of the mean.
struct PoseGaussian {
  Pose T_map_base;                              ///< mean
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();  ///< covariance of (x [m], y [m], yaw [rad]); may be singular
  /// Covariance of all six, with spatial motion; may be singular.
  std::optional<SpatialMatrix> P_spatial = std::nullopt;
};

/// What a map module extracted from one measurement. Created once, read by all particles.
class WAYMARK_TYPE Observation {
 public:
  virtual ~Observation() = default;
};

/// A particle's data association of one observation. Its content is defined by the map module.
class WAYMARK_TYPE Association {
 public:
  virtual ~Association() = default;
  bool refused = false;  ///< set by the host: it has not used the match
};

/// Information about all six of a pose, around the prior mean, in the form of `Refinement`.
struct SpatialInformation {
  SpatialMatrix information;  ///< Λ ⪰ 0, may be singular
  SpatialVector gradient;     ///< η

  /// Information about three of the six, whatever the others are: the marginal (a Schur complement).
  struct Marginal {
    Eigen::Matrix3d information;
    Eigen::Vector3d gradient;
  };
  WAYMARK_API Marginal planar() const;           ///< about (x, y, yaw)
  WAYMARK_API Marginal height_and_tilt() const;  ///< about (z, rotation about x, rotation about y)
};

/// Result of a match, in the same form for all map modules: information about (x, y, yaw) around the prior mean, and
/// the log evidence. The refined Gaussian is prior · exp(gradientᵀ d − ½ dᵀ information d), d = pose ⊟ prior mean.
struct Refinement {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< Λ ⪰ 0, may be singular
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();     ///< η
  double log_evidence = 0.0;                              ///< log p(observation | particle's past): the weight's factor
  /// False: `insert` will write nothing that depends on the pose. If no map writes, the host does not sample the pose.
  /// The particle then keeps its covariance until it re-observes its map.
  bool writes = true;
  /// True: the observation does not fit the map anywhere near the prior. False if it fits, and if there is nothing to
  /// fit it to yet.
  bool failed = false;
  std::unique_ptr<Association> association;  ///< kept by the host from step to step; a map can reuse its storage
  /// Of a map that matches all six of the pose (`MapModule::is_spatial`); not set on entry. `information` and
  /// `gradient` are then those about (x, y, yaw) alone: what is left if z, roll and pitch are unknown.
  std::optional<SpatialInformation> spatial = std::nullopt;
  /// Covariance of (x, y, yaw) by which the prior is wider, since the motion slipped: it missed a turn, say, by more
  /// than its noise says. Zero if it did not. The host widens the prior by it before it applies the information. The
  /// log evidence contains the probability of a slip.
  Eigen::Matrix3d slip = Eigen::Matrix3d::Zero();
  /// True: the observation contradicts the map where the prior expects it, although the prior is narrow, even after a
  /// search. What is new to the map is no such misfit, nor what hides the map, as people do.
  bool searched = false;
  /// A match that lies beyond what the prior expects, and what there is without it: the best match that the prior
  /// expects, or none.
  struct Jump {
    Eigen::Vector3d d;            ///< of the match from the prior mean: x [m], y [m], yaw [rad]
    Eigen::Matrix3d information;  ///< Λ, η and log evidence without it, as above
    Eigen::Vector3d gradient;
    double log_evidence;
    bool failed;
  };
  /// Set for such a match if the map can say what there is without it. The host may then refuse it, since the place may
  /// be another one (docs/math/joint.md).
  std::optional<Jump> jump = std::nullopt;
};

/// What of an observation ties the pose to places of the map (docs/math/joint.md).
struct Correspondences {
  /// A landmark that was observed, again or for the first time.
  struct Landmark {
    std::uint64_t birth;     ///< names it in the maps of all particles, as in `LandmarkView`
    bool is_new;             ///< `insert` will add it
    Eigen::Vector2d p_base;  ///< measured position in the base frame [m]
    Eigen::Matrix2d R;       ///< its noise [m²]
  };
  std::vector<Landmark> landmarks;
  std::vector<Eigen::Vector2d> points_base;  ///< of the surfaces that were matched, in the base frame [m]
};

/// One particle's map of one module. `clone` shares storage (copy-on-write) and is O(1) in the size of the map.
class WAYMARK_TYPE ParticleMap {
 public:
  virtual ~ParticleMap() = default;
  virtual std::unique_ptr<ParticleMap> clone() const = 0;

  /// Matches the observation against this map. `start`: a draw from the prior, where a search begins. Const, called
  /// from many threads on different particles. Information and evidence of `out` are zero on entry.
  virtual void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
                      Refinement& out) const = 0;

  /// Writes the observation into the map, at the sampled pose with the covariance that sampling kept. `association`:
  /// of the last `refine`; null where a map is drawn again, which counts nothing.
  virtual void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) = 0;

  /// Adds what the last `refine` found, for the joint Gaussian: landmarks, or points of surfaces. Called between
  /// `refine` and `insert`, for one particle. The default ties the pose to the place where the robot is.
  virtual void correspond(const Observation& /*observation*/, const Association* /*association*/,
                          Correspondences& out) const {
    out.points_base.emplace_back(0.0, 0.0);
  }

  /// The initial map again, with this map's figures, to draw all observations into at corrected poses (loops:
  /// docs/math/loops.md). Null if the module cannot (`MapModule::can_draw_again`).
  virtual std::unique_ptr<ParticleMap> blank() const { return nullptr; }

  /// Adds landmarks, figures and sightings to `out`. Called often.
  virtual void describe(MapDescription& out) const = 0;
  /// The map seen from above; nothing if it is not dense, or empty. A map of three dimensions returns a slice.
  virtual std::optional<GridView> grid() const { return std::nullopt; }
  /// The map as files, if its module has a file format. `T_enu_map`: place of the map on the Earth (planar). A format
  /// without it uses the map's own coordinates, and `MapFile::T_enu_file` says where they lie.
  virtual std::vector<MapFile> files(const Pose& /*T_enu_map*/) const { return {}; }
  /// Writes the map, for `MapModule::load_map`.
  virtual void save(OutArchive&) const = 0;
  /// Takes the figures of another map of the module, in whose place a `blank` one was drawn while it went on counting.
  virtual void take_figures(const ParticleMap& /*of*/) {}
};

}  // namespace waymark
