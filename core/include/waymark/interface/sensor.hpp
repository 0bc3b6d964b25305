// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string_view>

#include "waymark/interface/measurement.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/io/archive.hpp"

namespace waymark {

/// Where the map's origin lies on the Earth (WGS-84).
struct Datum {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_m = 0.0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(latitude_deg, longitude_deg, height_m);
  }
};

/// How far a measurement lies from what the mixture expects.
struct PredictedInnovation {
  gaussian::Vector nu;  ///< ν = z ⊟ h(x̄)
  gaussian::Matrix S;   ///< H P Hᵀ + R
};

/// The mixture at the measurement's stamp, its pose in ENU, read-only: for plausibility checks and adaptive noise.
/// What depends on one particle belongs in `Update::linearize`.
struct WAYMARK_API Prediction {
  const Belief& belief;
  const StateLayout& layout;
  const double* block;  ///< the sensor's own states of the mean
  const Datum* datum;   ///< null while unknown
  bool standing;        ///< the host holds the robot for standing still

  bool planar() const { return layout.motion() == StateLayout::Motion::planar; }
  /// The innovation that `update` would have, linearised at the mean. It must use no states of the sensor's own.
  PredictedInnovation innovation(const Update& update) const;
  /// Variances of the base's velocity, in its own axes [m²/s²]; 0 where planar motion holds it fixed.
  Eigen::Vector3d velocity_variance() const;
};

/// What one measurement says about the start, before there is a state.
struct StartHint {
  std::optional<Eigen::Vector3d> p_map_point;              ///< position of a point of the robot [m]; up may be 0
  Eigen::Vector3d p_base_point = Eigen::Vector3d::Zero();  ///< that point in the base frame (the lever arm) [m]
  double sigma_m = 0.0;                                    ///< per axis
  std::optional<double> yaw_rad;
  double yaw_sigma_rad = 0.0;
  std::optional<Datum> datum;  ///< proposes the map's origin; the first one wins
};

/// What the mixture made of one update, told back once per measurement, on the committed side.
struct Outcome {
  std::size_t update = 0;       ///< index within the measurement's updates
  gaussian::Vector innovation;  ///< ν = z − Σ w ẑ
  gaussian::Matrix S;           ///< Σ w (S_l + (ẑ_l − z̄)(ẑ_l − z̄)ᵀ)
  double nis = 0.0;             ///< νᵀ S⁻¹ ν
  bool accepted = false;
};

/// What the host needs to know of a sensor to fit it into the robot.
struct SensorTraits {
  bool is_motion_source = false;         ///< measures the motion (odometry, IMU, ego-velocity); a robot needs one
  bool is_absolute = false;              ///< ties the robot to the map's frame or to the Earth (GNSS, compass)
  bool observes_roll_and_pitch = false;  ///< `motion: { kind: spatial }` needs one that does
  /// An instrument that no other sensor may evaluate, since its reading would count twice: "a magnetometer". Empty:
  /// none. `unless` says how the YAML declares that it is another one: "set own_magnetometer: true".
  struct Instrument {
    std::string_view name = {};
    std::string_view unless = {};
  } instrument = {};
};

/// One sensor: turns its measurements into updates. `process` is called once per measurement, in stamp order, on one
/// thread; pre-processing and its state live here. Constructed from the YAML: `explicit MySensor(const Config&)` or
/// `MySensor(const Config&, const Rig&)`; valid when the constructor returns.
class WAYMARK_TYPE Sensor {
 public:
  virtual ~Sensor() = default;

  /// The sensor's own appended states; asked once, at load.
  virtual StateBlock block() const { return {}; }

  /// What the host needs to know of the sensor; asked once, at load.
  virtual SensorTraits traits() const { return {}; }

  /// What this measurement says about the start; called only while the filter has not started.
  virtual std::optional<StartHint> start_hint(const Measurement&, const Datum*) const { return std::nullopt; }

  /// Adds the updates that this measurement gives to `out` (cleared by the host). Throws DataError if the payload is
  /// unusable: the measurement is then counted and skipped.
  virtual void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) = 0;

  /// The outcome of one of the last measurement's updates.
  virtual void outcome(const Outcome&) {}

  virtual std::unique_ptr<Sensor> clone() const = 0;
  virtual void save(OutArchive&) const {}
  virtual void load(InArchive&) {}
};

}  // namespace waymark
