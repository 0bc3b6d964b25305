// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/interface/measurement.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/math/pose.hpp"

namespace waymark {

/// A Gaussian over the planar part (x, y, yaw) of a base pose; z, roll and pitch are those of the mean.
struct PoseGaussian {
  Pose T_map_base;                              ///< mean
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();  ///< covariance of (x [m], y [m], yaw [rad]); may be singular
};

/// What a map module found in one measurement: made once, read by all particles.
class WAYMARK_TYPE Observation {
 public:
  virtual ~Observation() = default;
};

/// A particle's own data association of one observation; what it holds is the map's business.
class WAYMARK_TYPE Association {
 public:
  virtual ~Association() = default;
};

/// The one currency between maps: information about (x, y, yaw) around the prior mean, and the log evidence. The
/// refined Gaussian is prior · exp(gradientᵀ d − ½ dᵀ information d), d = pose ⊟ prior mean.
struct Refinement {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< Λ ⪰ 0, may be singular
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();     ///< η
  double log_evidence = 0.0;                              ///< log p(observation | particle's past): the weight's factor
  /// False: `insert` will write nothing at a place that the pose decides. If no map writes, the host does not sample
  /// the pose: nothing is conditioned on it, and the particle keeps its uncertainty until it meets the map again.
  bool writes = true;
  std::unique_ptr<Association> association;  ///< kept by the host from step to step, so a map can reuse its storage
};

/// A landmark for sinks.
struct LandmarkView {
  std::int64_t id = 0;                              ///< stable within one particle's line of descent
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();  ///< east, north [m]
  double radius_m = 0.0;                            ///< NaN if the map has none
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();      ///< covariance of (east, north, radius)
  double existence = 0.0;                           ///< probability, 0..1
  int sightings = 0;
  bool confirmed = false;
};

/// A detection that went into a landmark, for scores of the data association.
struct Sighting {
  Time stamp{};
  Eigen::Vector2d p_base = Eigen::Vector2d::Zero();  ///< where the base saw it [m]
  std::int64_t landmark = -1;                        ///< `LandmarkView::id`, in this line of descent
  bool is_first = false;                             ///< it made that landmark
};

/// A number that a map tells about itself, for reports: "merged", 3.
struct MapFigure {
  std::string name;
  double value = 0.0;
};

/// A grid of square cells seen from above, for sinks.
struct GridView {
  static constexpr std::uint8_t kUnknown = 255;

  Pose T_map_grid;            ///< the lower left corner of the first cell; x along the rows
  double resolution_m = 0.0;  ///< side of a cell
  int width = 0;              ///< cells in a row
  int height = 0;             ///< rows
  /// Row by row from the lower left: probability of being occupied in percent, 0..100, or kUnknown.
  std::vector<std::uint8_t> cells = {};
};

/// A map as a file of its own kind, for other programs and for a later run.
struct MapFile {
  std::string extension;  ///< ".bt"; the host puts the map's name before it
  std::string content;    ///< all bytes of the file
};

/// What a particle's map shows to sinks.
struct MapDescription {
  std::string module;  ///< name of the map in the YAML
  std::vector<LandmarkView> landmarks;
  std::vector<MapFigure> figures = {};
  std::vector<Sighting> sightings = {};  ///< of the particle and its ancestors, if the map keeps them
  std::optional<GridView> grid = {};     ///< of a dense map; only if asked for
  /// What the maps of all particles make of each cell (`mix_grids`); only if asked for.
  std::optional<GridView> mixture = {};
  std::vector<MapFile> files = {};  ///< only if asked for
};

/// One particle's map of one module. `clone` shares storage (copy-on-write) and is O(1) in the size of the map.
class WAYMARK_TYPE ParticleMap {
 public:
  virtual ~ParticleMap() = default;
  virtual std::unique_ptr<ParticleMap> clone() const = 0;

  /// Matches the observation against this map. `start` is the host's own draw of the prior: where a search begins.
  /// Const, called from many threads on different particles. `out` arrives with zero information and evidence.
  virtual void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
                      Refinement& out) const = 0;

  /// Writes the observation into the map, at the sampled pose with the covariance that sampling kept.
  virtual void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) = 0;

  /// Landmarks, figures and sightings; called often.
  virtual void describe(MapDescription& out) const = 0;
  /// The map seen from above, if it is dense and not empty. A map of three dimensions shows a slice.
  virtual std::optional<GridView> grid() const { return std::nullopt; }
  /// The map as files, if it has a format of its own that others read. `T_enu_map` is where the map lies (planar); a
  /// format that has no way to say so gives the map's own coordinates.
  virtual std::vector<MapFile> files(const Pose& /*T_enu_map*/) const { return {}; }
  virtual void save(OutArchive&) const = 0;
};

/// A measurement that belongs to the trigger: the newest one of another input not later than it.
struct Companion {
  std::string_view input;          ///< name of the sensor
  const Measurement* measurement;  ///< null: none that is fresh enough; a case, not an error
};

/// How the robot stood and moved at the trigger's stamp, for levelling, de-skewing, pairing and spacing: the mixture's
/// mean. Where the map's place on the Earth is estimated the pose is in ENU: of it only roll and pitch are the map's.
struct MotionWindow {
  Eigen::Vector3d v_base = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d w_base = Eigen::Vector3d::Zero();  ///< [rad/s]
  Pose T_map_base = {};
  /// Motion of the base over a short time before or after the stamp, at constant twist: T_base(t)_base(t + dt).
  Pose relative(double dt) const { return {so3::exp(w_base * dt), so3::left_jacobian(w_base * dt) * v_base * dt}; }
};

/// A kind of map: one object for all particles. Constructed from the YAML: `MyMap(const Config&, const Rig&)`.
class WAYMARK_TYPE MapModule {
 public:
  virtual ~MapModule() = default;

  /// What a particle begins with: an empty map, or one that the YAML names.
  virtual std::unique_ptr<ParticleMap> create_map() const = 0;
  /// True if that is a map made before. Where the robot starts in it is then uncertain, as `initial:` says; without one
  /// and without absolute sensors the start is the map's own origin.
  virtual bool has_prior_map() const { return false; }

  /// Turns a measurement of the first input (with companions from the others) into an observation. Called once per
  /// measurement, in stamp order, on one thread. Throws DataError if it is unusable: it is then counted and skipped.
  virtual std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion> companions,
                                                     const MotionWindow& motion) = 0;

  /// Reads what `ParticleMap::save` wrote.
  virtual std::unique_ptr<ParticleMap> load_map(InArchive&) const = 0;
  /// Numbers about the module itself and about the maps of all particles together, for reports: what it found in its
  /// measurements so far, what the maps share. Called between measurements, on their thread. Shown with the figures of
  /// the best particle's map, so names must differ.
  virtual void describe(std::span<const ParticleMap* const> /*of_all_particles*/,
                        std::vector<MapFigure>& /*out*/) const {}
  /// The module's own state, if it has any.
  virtual void save(OutArchive&) const {}
  virtual void load(InArchive&) {}
};

}  // namespace waymark
