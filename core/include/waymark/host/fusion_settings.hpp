// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/config/config.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark {

/// Which of a sensor's measurements the filter sees; the others are held out, for scoring.
struct FuseRule {
  enum class Mode {
    all,
    start,      ///< only the first one, to find the start
    alternate,  ///< `on` fused, `off` held out, in turn from the first measurement
    stretches,  ///< every second stretch without a gap longer than `gap`, beginning with the first
    none
  };
  Mode mode = Mode::all;
  Duration on{};
  Duration off{};
  Duration gap{};
};

/// One sensor of the YAML: its plugin and what the host does with its updates.
struct SensorSlot {
  std::string name;
  std::string plugin;              ///< empty: only maps listen to it
  std::shared_ptr<Sensor> sensor;  ///< null: only maps listen to it
  bool enabled = true;
  FuseRule fuse;
  double gate_probability = 0.999;
  double weight_exponent = 1.0;
  int max_consecutive_rejections = 0;  ///< 0: never re-acquire
  Duration delay{};                    ///< how much later than true its stamps are
};

/// One map of the YAML.
struct MapSlot {
  std::string name;
  std::string plugin;
  std::shared_ptr<MapModule> module;
  std::vector<int> inputs;  ///< sensors, the first one triggers
  Duration pair_max_age{};
  bool localize = true;
  double share = 1.0;  ///< `information_share`
};

/// Where and how the filter begins (`initial:` of the YAML).
struct StartSettings {
  std::optional<Eigen::Vector2d> position;  ///< of the base; absent: from the sensors
  double height = 0.0;
  double position_sigma = 0.0;
  std::optional<double> yaw;  ///< absent: from the sensors
  double yaw_sigma = 0.0;
  double velocity_sigma = 3.0;  ///< of the unknown first twist
  double rate_sigma = 1.0;
  double min_course_distance = 0.5;  ///< heading from two fixes: at least this far apart
};

/// Which stamps the host believes.
struct ClockSettings {
  Duration max_ahead = from_seconds(0.1);  ///< a stamp may lie this far after its own arrival (clocks differ a little)
  Duration max_jump = std::chrono::hours(1);  ///< farther from all others: refused until several agree
};

/// When the host calls the pose degraded or lost.
struct HealthSettings {
  double lost_sigma = 10.0;                     ///< [m] standard deviation of the position, the larger axis
  Duration unaided_after = from_seconds(10.0);  ///< dead reckoning for longer than this is said so
};

/// Everything of the YAML that the host itself needs.
struct FusionSettings {
  StateLayout::Motion motion = StateLayout::Motion::planar;
  ProcessNoise process_noise;
  bool motion_from_maps = false;  ///< `motion.source: maps`: no motion sensor, only maps and the process model
  StartSettings start;
  std::optional<Datum> datum;
  ParticleFilterSettings filter;
  GeoreferenceSettings georeference;  ///< only used where an absolute sensor is fused and there are maps
  Duration max_latency{};
  Duration history = from_seconds(2.0);  ///< how far behind the commit horizon late data are still taken in
  bool smooth = false;                   ///< keep every step, for the smoothed trajectory; only without maps
  ClockSettings clock;
  HealthSettings health;
  Duration standstill_after = from_seconds(0.5);
  std::vector<std::string> notices = {};  ///< of the reading: old names of keys
};

/// Reads the host's own keys: `motion`, `initial`, `datum`, `filter`, `georeference`. Throws ConfigError.
WAYMARK_API FusionSettings read_fusion_settings(const Config& yaml);
/// Reads the keys of one entry of `sensors:` that the host itself needs (name, enabled, fuse…, gate…); the plugin is
/// not loaded here.
WAYMARK_API SensorSlot read_sensor_slot(const Config& entry);
/// Reads name, payload and `base_T_sensor` of one entry of `sensors:`.
WAYMARK_API Mounting read_mounting(const Config& entry);
/// Reads the keys of one entry of `maps:` that the host itself needs. Throws ConfigError if an input is no sensor.
WAYMARK_API MapSlot read_map_slot(const Config& entry, const Rig& rig);
/// Fills in shares: maps that localise with one trigger share its information, by default equally. Throws ConfigError
/// if a sum exceeds 1.
WAYMARK_API void settle_shares(std::vector<MapSlot>& maps, const Config& yaml);

}  // namespace waymark
