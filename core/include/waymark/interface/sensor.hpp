// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string_view>

#include "waymark/interface/measurement.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/observed_motion.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/io/archive.hpp"

namespace waymark {

/// The map's origin on the Earth (WGS-84).
struct Datum {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_m = 0.0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive.within(latitude_deg, -90.0, 90.0);
    archive.within(longitude_deg, -180.0, 180.0);
    archive(height_m);
  }
};

/// Innovation of a measurement for the mixture.
struct PredictedInnovation {
  gaussian::Vector nu;  ///< ν = z ⊟ h(x̄)
  gaussian::Matrix S;   ///< H P Hᵀ + R
};

/// The mixture predicted to the measurement's stamp, its pose in ENU: for plausibility checks and adaptive noise.
/// Computations that depend on the particle belong in `Update::linearize`.
struct WAYMARK_API Prediction {
  const Belief& belief;
  const StateLayout& layout;
  const double* block;  ///< the sensor's own states of the mean
  const Datum* datum;   ///< null while unknown
  bool standing;        ///< the host detects standstill

  /// True for planar motion: z, roll, pitch and their rates are not states.
  bool planar() const { return layout.motion() == StateLayout::Motion::planar; }
  /// The innovation of `update`, linearised at the mean. `update` must not use the sensor's own states.
  PredictedInnovation innovation(const Update& update) const;
  /// Variances of the base's velocity, in its own axes [m²/s²]; 0 where planar motion holds it fixed.
  Eigen::Vector3d velocity_variance() const;
};

/// Information of one measurement about the start pose, before the filter has started.
struct StartHint {
  std::optional<Eigen::Vector3d> p_map_point;              ///< position of a point of the robot [m]; up may be 0
  Eigen::Vector3d p_base_point = Eigen::Vector3d::Zero();  ///< that point in the base frame (the lever arm) [m]
  double sigma_m = 0.0;                                    ///< σ of the position per axis, the slow part included
  double slow_sigma_m = 0.0;      ///< of a slowly varying error in it (first-order Gauss–Markov)
  double slow_tau_s = 0.0;        ///< time constant of that; 0: there is none
  std::optional<double> yaw_rad;  ///< heading, counter-clockwise from east
  double yaw_sigma_rad = 0.0;
  std::optional<Datum> datum;  ///< proposed origin of the map; the first one is used
};

/// Result of one update for the mixture, reported to the sensor once by the committed filter.
struct Outcome {
  std::size_t update = 0;       ///< index within the measurement's updates
  gaussian::Vector innovation;  ///< ν = z − Σ w ẑ
  gaussian::Matrix S;           ///< Σ w (S_l + (ẑ_l − z̄)(ẑ_l − z̄)ᵀ)
  double nis = 0.0;             ///< νᵀ S⁻¹ ν
  bool accepted = false;
};

/// Properties of a sensor that the host needs.
struct SensorTraits {
  bool is_motion_source = false;         ///< measures the motion (odometry, IMU, ego-velocity); a robot needs one
  bool is_absolute = false;              ///< ties the robot to the map's frame or to the Earth (GNSS, compass)
  bool observes_roll_and_pitch = false;  ///< `motion: { kind: spatial }` needs one that does
  /// An instrument that only one sensor may use, since its errors would count twice: "a magnetometer". Empty: none.
  /// `unless`: how the YAML declares that it is another instrument: "set own_magnetometer: true".
  struct Instrument {
    std::string_view name = {};
    std::string_view unless = {};
  } instrument = {};
  bool observes_height = false;  ///< the height, or the velocity up: else it drifts freely in spatial motion
};

/// One sensor: turns its measurements into updates. `process` is called once per measurement, in stamp order, on one
/// thread; pre-processing and its state belong here. Constructed from the YAML: `explicit MySensor(const Config&)` or
/// `MySensor(const Config&, const Rig&)`; valid when the constructor returns.
class WAYMARK_TYPE Sensor {
 public:
  virtual ~Sensor() = default;

  /// The sensor's own states; read at load; must not change afterwards.
  virtual StateBlock block() const { return {}; }

  /// The sensor's properties; read at load; must not change afterwards.
  virtual SensorTraits traits() const { return {}; }

  /// Information of this measurement about the start pose; called only before the filter has started. The datum is null
  /// while unknown.
  virtual std::optional<StartHint> start_hint(const Measurement&, const Datum*) const { return std::nullopt; }

  /// What this measurement by itself contains about the motion, for the comparison of sensors with each other; called
  /// for every measurement, whatever the filter makes of it, on the thread of `process`. The datum is null while
  /// unknown. Cheap, and without allocation; throws DataError if the payload is unusable.
  virtual std::optional<ObservedMotion> observed_motion(const Measurement&, const Datum*) const { return std::nullopt; }

  /// Adds the updates of this measurement to `out` (empty on entry). Throws DataError if the payload is unusable: the
  /// measurement is then counted and skipped.
  virtual void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) = 0;

  /// Receives the result of one of the last measurement's updates.
  virtual void outcome(const Outcome&) {}

  /// A copy with its own state, for rollbacks and for `Fusion::front`.
  virtual std::unique_ptr<Sensor> clone() const = 0;
  /// The sensor's own state, if it has any.
  virtual void save(OutArchive&) const {}
  virtual void load(InArchive&) {}
};

}  // namespace waymark
