// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/interface/measurement.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark {

/// The newest measurement of another input that is not later than the trigger.
struct Companion {
  std::string_view input;          ///< name of the sensor
  const Measurement* measurement;  ///< null: none is recent enough, which is not an error
};

/// Pose and twist of the mixture's mean at the trigger's stamp, for levelling, motion compensation (de-skewing),
/// pairing and spacing. With a georeference the pose is in ENU; only its roll and pitch are then those in the map.
struct MotionWindow {
  Eigen::Vector3d v_base = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d w_base = Eigen::Vector3d::Zero();  ///< [rad/s]
  Pose T_map_base = {};
  /// False while no sensor measures the velocity (scanners alone, an IMU beside them, wheels that fell silent): it
  /// follows from the maps themselves then, so a map that waits for motion before it uses a scan would wait for ever.
  bool is_measured = true;
  /// Motion of the base over a short time before or after the stamp, at constant twist: T_base(t)_base(t + dt).
  Pose relative(double dt) const { return {so3::exp(w_base * dt), so3::left_jacobian(w_base * dt) * v_base * dt}; }
};

/// The frame in which a loaded map lies: east, north, up at the datum, or without one that of the run that wrote it.
struct MapFrame {
  std::string manifest;  ///< the file that says so
  std::optional<Datum> datum;
};

/// A map module: one object for all particles. Constructed from the YAML: `MyMap(const Config&, const Rig&)`.
class WAYMARK_TYPE MapModule {
 public:
  virtual ~MapModule() = default;

  /// The initial map of a particle: empty, or loaded from the file that the YAML names.
  virtual std::unique_ptr<ParticleMap> create_map() const = 0;
  /// True if the initial map is a prior map. The start pose then has the uncertainty of `initial:`. Without a prior map
  /// and without absolute sensors the start pose is the map's origin. Must not change after load.
  virtual bool has_prior_map() const { return false; }

  /// The frame of the prior map, if its file says so. All maps of a robot must lie in one, and its datum is the
  /// robot's.
  virtual std::optional<MapFrame> prior_frame() const { return std::nullopt; }

  /// Turns a measurement of the first input (with companions from the others) into an observation; null if the module
  /// does not use it. Called once per measurement, in stamp order, on one thread. `companions` and the measurements
  /// that they point to are valid until `extract` returns; to use one later, copy it. Throws DataError if the
  /// measurement is unusable: it is then counted and skipped.
  virtual std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion> companions,
                                                     const MotionWindow& motion) = 0;

  /// True if the module's maps can be drawn again from observations: `ParticleMap::blank`, `save_observation` and
  /// `load_observation` are there. Must not change after load.
  virtual bool can_draw_again() const { return false; }
  /// An observation on a checkpoint, for a map that can be drawn again.
  virtual void save_observation(const Observation& /*observation*/, OutArchive& /*out*/) const {}
  virtual std::shared_ptr<const Observation> load_observation(InArchive& /*in*/) const { return nullptr; }

  /// Reads a map that `ParticleMap::save` wrote.
  virtual std::unique_ptr<ParticleMap> load_map(InArchive&) const = 0;
  /// Adds figures of the module and of the maps of all particles together, for reports: detections so far, shared
  /// storage. Called between measurements, on the same thread. Listed with the figures of the best particle's map, so
  /// names must differ.
  virtual void describe(std::span<const ParticleMap* const> /*of_all_particles*/,
                        std::vector<MapFigure>& /*out*/) const {}
  /// The module's own state, if it has any.
  virtual void save(OutArchive&) const {}
  virtual void load(InArchive&) {}

  /// True if its maps match all six of the pose (`Refinement::spatial`), which needs spatial motion. All six are then
  /// sampled before a map is written. Must not change after load.
  virtual bool is_spatial() const { return false; }
};

}  // namespace waymark
