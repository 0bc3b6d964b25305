// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/config/config.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark {

class MapModule;

/// Which of a sensor's measurements are fused. The others are held out, for scoring.
struct FuseRule {
  enum class Mode {
    all,
    start,      ///< none is fused; they find the start only
    alternate,  ///< `on` fused, `off` held out, in turn from the first measurement
    stretches,  ///< every second stretch without a gap longer than `gap`, beginning with the first
    none
  };
  Mode mode = Mode::all;
  Duration on = from_seconds(10.0);
  Duration off = from_seconds(10.0);
  Duration gap = from_seconds(1.0);
};

/// What the filter does with the measurements of a sensor.
enum class SensorMode {
  fused,
  shadow,  ///< evaluated only: NIS and gate are counted, the pose does not depend on it
  off      ///< held out
};

/// One sensor of the YAML: its plugin and what the host does with its updates.
struct SensorSlot {
  std::string name;
  std::string plugin;              ///< empty: for maps only
  std::shared_ptr<Sensor> sensor;  ///< null: for maps only
  bool enabled = true;
  FuseRule fuse;
  double gate_probability = 0.999;
  double weight_exponent = 1.0;
  int max_consecutive_rejections = 20;  ///< until it is re-acquired; 0: never
  Duration delay{};                     ///< of its stamps; subtracted
};

/// One map of the YAML.
struct MapSlot {
  std::string name;
  std::string plugin;
  std::shared_ptr<MapModule> module;
  std::vector<int> inputs;  ///< indices of sensors; the first one triggers
  Duration pair_max_age = from_seconds(0.15);
  bool localize = true;
  double share = 1.0;  ///< `information_share`
};

/// Start pose and its uncertainty (`initial:` of the YAML).
struct StartSettings {
  std::optional<Eigen::Vector2d> position;  ///< of the base; absent: from the sensors
  double height = 0.0;
  double position_sigma = 0.0;
  std::optional<double> yaw;  ///< absent: from the sensors
  double yaw_sigma = 0.0;
  double velocity_sigma = 3.0;  ///< of the unknown first twist
  double rate_sigma = 1.0;
  double min_course_distance = 0.5;  ///< least distance of the antenna between fixes that give a heading [m]
};

/// Limits of plausible stamps, and of gaps between them (`clock:` of the YAML).
struct ClockSettings {
  Duration max_ahead = from_seconds(0.1);      ///< a stamp may be this far after its own arrival
  Duration max_jump = std::chrono::hours(1);   ///< a stamp farther from all others is rejected until several agree
  Duration max_gap = std::chrono::minutes(1);  ///< after a longer one, once several agree, the pose is found anew
};

/// Thresholds of the pose's health (`health:` of the YAML).
struct HealthSettings {
  double lost_sigma = 10.0;                     ///< lost above this σ of the position, larger axis [m]
  Duration unaided_after = from_seconds(10.0);  ///< dead reckoning for longer is reported as degraded
  double max_lost_share = 0.1;                  ///< a run that was lost for a larger share of its time has failed
};

/// The settings of the host itself.
struct FusionSettings {
  StateLayout::Motion motion = StateLayout::Motion::planar;
  ProcessNoise process_noise;
  bool motion_from_maps = false;  ///< `motion.source: maps`: no motion sensor, only maps and the process model
  StartSettings start;
  std::optional<Datum> datum;
  ParticleFilterSettings filter;
  GeoreferenceSettings georeference;  ///< only used where an absolute sensor is fused and there are maps
  Duration max_latency{};
  Duration history = from_seconds(2.0);  ///< late measurements up to this far behind the committed time are processed
  bool smooth = false;                   ///< store every step, for the smoothed trajectory; without maps only
  ClockSettings clock;
  HealthSettings health;
  Duration standstill_after = from_seconds(0.5);
  std::vector<std::string> notices = {};  ///< old names of keys that were read
};

/// Reads the host's own keys: `motion`, `initial`, `datum`, `filter`, `georeference`. Throws ConfigError.
WAYMARK_API FusionSettings read_fusion_settings(const Config& yaml);
/// Reads the keys of one entry of `sensors:` that the host itself needs (name, enabled, fuse…, gate…). Does not load
/// the plugin. Throws ConfigError.
WAYMARK_API SensorSlot read_sensor_slot(const Config& entry);
/// True if one entry of `sensors:` leaves it to the source where the sensor is mounted (`base_T_sensor: from_tf`), and
/// nobody has put that in its place yet (`Config::replace`).
WAYMARK_API bool is_mounted_by_source(const Config& entry);
/// Reads name, payload and `base_T_sensor` of one entry of `sensors:`. Throws ConfigError.
WAYMARK_API Mounting read_mounting(const Config& entry);
/// Reads the keys of one entry of `maps:` that the host itself needs. Throws ConfigError, also if an input is not a
/// sensor of the rig.
WAYMARK_API MapSlot read_map_slot(const Config& entry, const Rig& rig);
/// Normalises shares: maps that localise with one trigger share its information, equally by default. Throws ConfigError
/// if a sum exceeds 1.
WAYMARK_API void normalize_shares(std::vector<MapSlot>& maps, const Config& yaml);

}  // namespace waymark
