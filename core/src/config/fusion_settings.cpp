// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/fusion_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace waymark {

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr std::string_view kFromTf = "from_tf";
constexpr double kShareNotGiven = -1.0;
constexpr double kFarthest = 1e8;  // m; beyond, doubles are too coarse for a place

/// A default in seconds: the double nearest to its decimal number, as a person would write it.
double default_s(Duration duration) { return static_cast<double>(duration.count()) / 1e9; }

std::vector<double> list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ProcessNoise read_process_noise(const Config& motion) {
  ProcessNoise noise;
  const auto velocity = motion.numbers(
      {"velocity_noise_mps_per_sqrt_s", "m/s/√s", "white acceleration forwards, sideways, up, as a density"}, 3,
      list(noise.velocity_per_sqrt_s));
  const auto rate = motion.numbers(
      {"rate_noise_radps_per_sqrt_s", "rad/s/√s", "white angular acceleration about x, y, z, as a density"}, 3,
      list(noise.rate_per_sqrt_s));
  for (int i = 0; i < 3; ++i) {
    if (velocity[static_cast<std::size_t>(i)] < 0.0) motion.fail("velocity_noise_mps_per_sqrt_s", "must be >= 0");
    if (rate[static_cast<std::size_t>(i)] < 0.0) motion.fail("rate_noise_radps_per_sqrt_s", "must be >= 0");
    noise.velocity_per_sqrt_s[i] = velocity[static_cast<std::size_t>(i)];
    noise.rate_per_sqrt_s[i] = rate[static_cast<std::size_t>(i)];
  }
  return noise;
}

void read_motion(const Config& motion, FusionSettings& settings) {
  const std::string kind = motion.choice({"kind",
                                          "`planar`: z, roll, pitch, v_z, ω_x, ω_y stay fixed; `spatial`: they are "
                                          "estimated, which needs a sensor that observes roll and pitch, such as imu"},
                                         {"planar", "spatial"}, "planar");
  settings.motion = kind == "planar" ? StateLayout::Motion::planar : StateLayout::Motion::spatial;
  settings.process_noise = read_process_noise(motion);
  const bool old_name = motion.has("told_by") && !motion.has("source");
  const Config::Key old_key{"told_by", "old name of `source`"};
  const Config::Key key{
      "source",
      "`sensors`: the twist is measured; `maps`: there is no motion sensor (no odometry), the twist is "
      "constant up to the noise densities, each match against the map corrects pose and twist, and the "
      "first mapping measurement starts the filter"};
  settings.motion_from_maps = motion.choice(old_name ? old_key : key, {"sensors", "maps"}, "sensors") == "maps";
  settings.standstill_after = from_seconds(
      motion.positive({"standstill_after_s", "s", "all motion sensors report no motion for this time: standstill"},
                      default_s(settings.standstill_after)));
}

StartSettings read_start(const Config& initial) {
  StartSettings start;
  if (initial.has("x_m") || initial.has("y_m")) {
    const double x = initial.number_in(
        {"x_m", "m", "position of the base in the map, towards the east; both `x_m` and `y_m` or none",
         "from the sensors"},
        -kFarthest, kFarthest);
    const double y = initial.number_in(
        {"y_m", "m", "position of the base in the map, towards the north; both `x_m` and `y_m` or none",
         "from the sensors"},
        -kFarthest, kFarthest);
    start.position = Eigen::Vector2d(x, y);
  }
  start.height = initial.number_in({"z_m", "m", "height of the base in the map"}, -kFarthest, kFarthest, start.height);
  start.position_sigma = initial.number_in(
      {"position_sigma_m", "m", "σ of the position per axis; of a position from a fix at least the fix's own"}, 0.0,
      1e7, 0.0);
  if (initial.has("yaw_deg")) {
    start.yaw =
        kRadPerDeg *
        initial.number_in({"yaw_deg", "°", "heading, counter-clockwise from east", "from the sensors"}, -360.0, 360.0);
  }
  start.yaw_sigma =
      kRadPerDeg * initial.number_in({"yaw_sigma_deg", "°", "σ of the heading; of a heading from fixes the least σ",
                                      "0 if `yaw_deg` is given, else 10"},
                                     0.0, 180.0, start.yaw ? 0.0 : 10.0);
  start.velocity_sigma =
      initial.positive({"speed_sigma_mps", "m/s", "σ of the unknown first velocity"}, start.velocity_sigma);
  start.rate_sigma =
      initial.positive({"rate_sigma_radps", "rad/s", "σ of the unknown first angular rate"}, start.rate_sigma);
  start.min_course_distance = initial.positive(
      {"min_course_distance_m", "m",
       "fixes give a heading if the antenna has moved so far between them, and if its σ is below 11.5°"},
      start.min_course_distance);
  return start;
}

FuseRule read_fuse_rule(const Config& entry) {
  FuseRule rule;
  const std::string mode =
      entry.choice({"fuse",
                    "which measurements are fused: `all`; `start` (to find the start only); `alternate`; `stretches` "
                    "(every second stretch without a gap); `none`; the others are held out for scoring"},
                   {"all", "start", "alternate", "stretches", "none"}, "all");
  if (mode == "start") rule.mode = FuseRule::Mode::start;
  if (mode == "none") rule.mode = FuseRule::Mode::none;
  // Read whatever the mode is: one file then serves all modes through a variable.
  rule.on = from_seconds(entry.positive({"fuse_on_s", "s", "for `fuse: alternate`: measurements are fused for so long"},
                                        default_s(rule.on)));
  rule.off = from_seconds(entry.positive(
      {"fuse_off_s", "s", "for `fuse: alternate`: then they are held out for so long"}, default_s(rule.off)));
  rule.gap = from_seconds(entry.positive(
      {"fuse_gap_s", "s", "for `fuse: stretches`: a longer gap begins a new stretch"}, default_s(rule.gap)));
  if (mode == "alternate") rule.mode = FuseRule::Mode::alternate;
  if (mode == "stretches") rule.mode = FuseRule::Mode::stretches;
  return rule;
}

GeoreferenceSettings read_georeference(const Config& config) {
  GeoreferenceSettings georeference;
  georeference.enabled = config.boolean(
      {"enabled", "false: absolute sensors correct the pose in the map, as in the paper"}, georeference.enabled);
  georeference.position_walk_per_sqrt_m = config.non_negative(
      {"position_walk_m_per_sqrt_m", "m/√m", "drift of the map against the Earth, per √metre driven"},
      georeference.position_walk_per_sqrt_m);
  georeference.yaw_walk_per_sqrt_m =
      kRadPerDeg * config.non_negative({"yaw_walk_deg_per_sqrt_m", "°/√m",
                                        "drift of the map's heading against the Earth, per √metre driven"},
                                       georeference.yaw_walk_per_sqrt_m / kRadPerDeg);
  return georeference;
}

Datum read_datum(const Config& datum) {
  return {datum.number_in({"latitude_deg", "°", "latitude of the origin"}, -90.0, 90.0),
          datum.number_in({"longitude_deg", "°", "longitude of the origin"}, -180.0, 180.0),
          datum.number({"height_m", "m", "height of the origin"}, 0.0)};
}

void read_filter(const Config& filter, bool has_maps, FusionSettings& settings) {
  settings.filter.particles = static_cast<int>(filter.integer_in(
      {"particles", "", "number of particles", "25 with `maps`, else 1"}, 1, 1'000'000, has_maps ? 25 : 1));
  settings.filter.seed = static_cast<std::uint64_t>(
      filter.integer_in({"seed", "for all random numbers of the filter (the simulator has its own)"}, 0,
                        std::numeric_limits<std::int64_t>::max(), static_cast<std::int64_t>(settings.filter.seed)));
  settings.filter.resample_threshold =
      filter.number_in({"resample_threshold", "resample when N_eff falls below this share of the particles"}, 0.0, 1.0,
                       settings.filter.resample_threshold);
  settings.filter.sampling_fraction = filter.number_in({"sampling_fraction",
                                                        "share of the pose's covariance that a mapping step samples; 1 "
                                                        "is FastSLAM 2.0 as published (docs/math/rbpf.md)"},
                                                       0.0, 1.0, settings.filter.sampling_fraction);
  settings.filter.threads = static_cast<int>(filter.integer_in(
      {"threads", "number of threads; results do not depend on it"}, 1, 256, settings.filter.threads));
  settings.filter.path_poses = static_cast<std::size_t>(filter.integer_in(
      {"path_poses",
       "most poses of a path that are kept; of a longer one the older half loses every second pose, so a robot that "
       "runs for months needs no more memory"},
      1000, 1'000'000'000, static_cast<std::int64_t>(settings.filter.path_poses)));
  settings.max_latency = from_seconds(filter.non_negative(
      {"max_latency_s", "s", "measurements up to this late are put in order; the committed result lags by it"},
      default_s(settings.max_latency)));
  settings.history = from_seconds(filter.number_in(
      {"history_s", "s",
       "later measurements up to this age are still processed (docs/math/time.md); 0: they are ignored"},
      0.0, 600.0, default_s(settings.history)));
  settings.smooth =
      filter.boolean({"smooth", "also write the smoothed trajectory; without `maps` only"}, settings.smooth);
  if (settings.smooth && has_maps) filter.fail("smooth", "the smoother works without maps only");
}

ClockSettings read_clock(const Config& config) {
  ClockSettings clock;
  clock.max_ahead = from_seconds(config.non_negative(
      {"max_ahead_s", "s", "a stamp may lie this far after its own arrival"}, default_s(clock.max_ahead)));
  clock.max_jump = from_seconds(
      config.positive({"max_jump_s", "s", "a stamp this far from all others is rejected until several agree"},
                      default_s(clock.max_jump)));
  clock.max_gap = from_seconds(config.positive(
      {"max_gap_s", "s",
       "after a longer gap without any measurement the pose is not predicted but found anew, as at the start"},
      default_s(clock.max_gap)));
  return clock;
}

HealthSettings read_health(const Config& config) {
  HealthSettings health;
  health.lost_sigma =
      config.positive({"lost_sigma_m", "m", "a position less certain than this (σ, larger axis) is reported as lost"},
                      health.lost_sigma);
  health.unaided_after = from_seconds(
      config.positive({"unaided_after_s", "s", "dead reckoning for longer than this is reported as degraded"},
                      default_s(health.unaided_after)));
  health.max_lost_share =
      config.number_in({"max_lost_share", "a run that was lost for a larger share of its time ends with exit code 4"},
                       0.0, 1.0, health.max_lost_share);
  return health;
}

JointSettings read_joint(const Config& yaml) {
  JointSettings joint;
  joint.enabled = yaml.boolean({"enabled", "false: the covariance of the particles alone is reported"}, joint.enabled);
  joint.anchor_spacing = yaml.number_in({"anchor_spacing_m", "m", "distance between the anchors of a dense map"}, 0.5,
                                        1000.0, joint.anchor_spacing);
  joint.anchor_sigma = yaml.number_in(
      {"anchor_sigma_m", "m",
       "σ of the error of position that all places have in common which were first mapped from one anchor"},
      0.0, 10.0, joint.anchor_sigma);
  joint.anchor_yaw_sigma = kRadPerDeg * yaml.number_in({"anchor_yaw_sigma_deg", "deg", "the same of their heading"},
                                                       0.0, 90.0, joint.anchor_yaw_sigma / kRadPerDeg);
  return joint;
}

LoopSettings read_loops(const Config& yaml) {
  LoopSettings loops;
  loops.enabled = yaml.boolean({"enabled", "false: places that are met again do not correct the maps"}, loops.enabled);
  loops.least_way = yaml.number_in(
      {"least_way_m", "m", "distance driven since a place was seen, after which it is searched for as a loop"}, 5.0,
      1e6, loops.least_way);
  loops.search_distance = yaml.number_in({"search_distance_m", "m", "half width of the search for a place, at most"},
                                         0.5, 50.0, loops.search_distance);
  loops.search_angle =
      kRadPerDeg * yaml.number_in({"search_angle_deg", "deg", "half width of that search in heading, at most"}, 1.0,
                                  180.0, loops.search_angle / kRadPerDeg);
  loops.least_shift = yaml.number_in({"least_shift_m", "m", "the maps are drawn again where a loop moves them farther"},
                                     0.0, 100.0, loops.least_shift);
  return loops;
}

}  // namespace

FusionSettings read_fusion_settings(const Config& yaml) {
  FusionSettings settings;
  read_motion(yaml.child_or_empty({"motion", "model of the robot's motion"}), settings);
  settings.start = read_start(yaml.child_or_empty({"initial", "pose and twist at the start"}));
  if (yaml.has("datum")) {
    settings.datum = read_datum(
        yaml.child({"datum", "", "the map's origin on the Earth (WGS-84)", "the first plausible geodetic fix"}));
  }
  const Config filter = yaml.child_or_empty({"filter", "particles, and the order of measurements"});
  read_filter(filter, yaml.is_list("maps") && !yaml.items("maps").empty(), settings);
  settings.filter.joint = read_joint(yaml.child_or_empty(
      {"joint",
       "the joint Gaussian over the pose and the places of the maps, whose covariance is reported; used with maps"}));
  settings.filter.loops =
      read_loops(yaml.child_or_empty({"loops", "places that are met again, and the correction of dense maps between"}));
  const Config relocation = yaml.child_or_empty(
      {"relocation", "the search for a robot that is not where it is believed to be in a loaded map"});
  settings.filter.relocation.enabled =
      relocation.boolean({"enabled", "false: such a robot is not searched for"}, settings.filter.relocation.enabled);
  settings.clock = read_clock(yaml.child_or_empty({"clock", "which stamps are plausible"}));
  settings.health = read_health(yaml.child_or_empty({"health", "when the result is reported as lost or degraded"}));
  settings.georeference =
      read_georeference(yaml.child_or_empty({"georeference",
                                             "the map's place on the Earth as states of the filter; used only with "
                                             "maps and a fused absolute sensor (GNSS, compass)"}));
  return settings;
}

namespace {

Intrinsics read_intrinsics(const Config& entry) {
  const auto positive = [&](const Config::Key& key) {
    std::vector<double> values = entry.numbers(key, 2);
    if (!(values[0] > 0.0) || !(values[1] > 0.0)) entry.fail(key.name, "two numbers > 0 are expected");
    return values;
  };
  const auto size = positive({"size_px", "px", "[width, height] of the image"});
  if (size[0] != std::floor(size[0]) || size[1] != std::floor(size[1]) || size[0] > 65536 || size[1] > 65536)
    entry.fail("size_px", "two whole numbers up to 65536 are expected: width, height");
  const auto focal = positive({"focal_px", "px", "focal lengths [fx, fy]"});
  const auto center = entry.numbers({"center_px", "px", "principal point [cx, cy]"}, 2);
  const auto distortion =
      entry.numbers({"distortion", "", "[k1, k2, p1, p2, k3] of the lens", "none"}, 5, {0.0, 0.0, 0.0, 0.0, 0.0});
  Intrinsics intrinsics{static_cast<int>(size[0]), static_cast<int>(size[1]), focal[0], focal[1], center[0], center[1]};
  std::ranges::copy(distortion, intrinsics.distortion.begin());
  return intrinsics;
}

}  // namespace

namespace {

/// Of a sensor or a map: it stands in messages and tables.
std::string read_name(const Config& entry, const Config::Key& key) {
  std::string name = entry.text(key);
  if (name.empty()) entry.fail(key.name, "is empty, a name is expected");
  if (std::ranges::any_of(name, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
    entry.fail(key.name, "a name has no control characters");
  return name;
}

}  // namespace

bool is_mounted_by_source(const Config& entry) { return entry.is_word("base_T_sensor", kFromTf); }

Mounting read_mounting(const Config& entry) {
  Mounting mounting;
  mounting.name = read_name(entry, {"name", "unique; the source, `inputs` and `--set` refer to it"});
  mounting.payload = entry.text(
      {"payload", "", "payload type, `LaserScan` for `waymark/LaserScan@1`, or a full name", "that of the plugin"}, "");
  if (!mounting.payload.empty() && mounting.payload.find('/') == std::string::npos)
    mounting.payload = "waymark/" + mounting.payload + "@1";
  if (is_mounted_by_source(entry)) {
    entry.text("base_T_sensor");  // it is settled later, or the sensor has none
  } else if (entry.has("base_T_sensor")) {
    if (entry.is_list("base_T_sensor"))
      entry.fail("base_T_sensor", "a list is not a mapping; write { xyz_m: [x, y, z], yaw_deg: 0 }");
    const Config extrinsics = entry.child({"base_T_sensor", "",
                                           "pose of the sensor in the base frame: x forward, y left, z up, also for a "
                                           "camera; required if a plugin needs it. `from_tf`: what the source learns "
                                           "from the robot (`/tf_static` of ROS 2)",
                                           "none"});
    const auto xyz =
        extrinsics.numbers({"xyz_m", "m", "position [x, y, z] of the sensor in the base frame"}, 3, {0.0, 0.0, 0.0});
    mounting.T_base_sensor = Pose{
        so3::from_rpy(
            kRadPerDeg * extrinsics.number({"roll_deg", "°", "rotation about x; R = Rz(yaw) Ry(pitch) Rx(roll)"}, 0.0),
            kRadPerDeg * extrinsics.number({"pitch_deg", "°", "rotation about y"}, 0.0),
            kRadPerDeg * extrinsics.number({"yaw_deg", "°", "rotation about z"}, 0.0)),
        {xyz[0], xyz[1], xyz[2]}};
  }
  if (entry.has("intrinsics"))
    mounting.intrinsics = read_intrinsics(entry.child({"intrinsics", "", "of a camera, in OpenCV's model", "none"}));
  return mounting;
}

SensorSlot read_sensor_slot(const Config& entry) {
  SensorSlot slot;
  slot.name = entry.text("name");
  slot.plugin = entry.text(
      {"plugin", "", "name of the sensor's plugin; absent: the sensor is for maps only and needs `payload`", "none"},
      "");
  slot.enabled =
      entry.boolean({"enabled", "false: its measurements are ignored, its keys are not checked"}, slot.enabled);
  slot.fuse = read_fuse_rule(entry);
  slot.gate_probability =
      entry.number_in({"gate_probability", "a measurement is rejected if its NIS exceeds this χ² quantile"}, 0.5,
                      1.0 - 1e-12, slot.gate_probability);
  slot.weight_exponent = entry.number_in(
      {"weight_exponent", "exponent of the evidence in the particles' weights; below 1 for correlated errors"}, 0.0,
      1.0, slot.weight_exponent);
  slot.max_consecutive_rejections = static_cast<int>(
      entry.integer_in({"max_consecutive_rejections",
                        "after so many in a row the belief is widened and the measurement accepted; 0: never"},
                       0, 1'000'000, slot.max_consecutive_rejections));
  slot.delay = from_seconds(entry.number_in({"delay_s", "s", "delay of the sensor's stamps; subtracted"}, -60.0, 60.0,
                                            default_s(slot.delay)));
  return slot;
}

MapSlot read_map_slot(const Config& entry, const Rig& rig) {
  MapSlot slot;
  slot.name = read_name(entry, {"name", "unique"});
  slot.plugin = entry.text({"plugin", "name of the map module's plugin"});
  for (const std::string& input :
       entry.texts({"inputs", "sensors by name; the first triggers, the others contribute their newest measurement"})) {
    const int sensor = rig.find(input);
    if (sensor < 0) {
      std::string names;
      for (const Mounting& mounting : rig.mountings()) names += (names.empty() ? "" : ", ") + mounting.name;
      entry.fail("inputs", fmt::format("\"{}\" is not a sensor of this file; there are: {}", input, names));
    }
    slot.inputs.push_back(sensor);
  }
  if (slot.inputs.empty()) entry.fail("inputs", "needs at least one sensor");
  slot.pair_max_age = from_seconds(entry.non_negative(
      {"pair_max_age_s", "s", "greatest age of another input's newest measurement against the trigger"},
      default_s(slot.pair_max_age)));
  slot.localize = entry.boolean({"localize", "false: the module only maps"}, slot.localize);
  slot.share =
      entry.has("information_share")
          ? entry.number_in({"information_share", "",
                             "exponent of the module's likelihood; the sum over the modules that localise with the "
                             "same trigger may not exceed 1, or the same beams would count twice",
                             "1/n, if n modules localise with the same trigger"},
                            0.0, 1.0)
          : kShareNotGiven;
  return slot;
}

void normalize_shares(std::vector<MapSlot>& maps, const Config& yaml) {
  std::map<int, std::vector<MapSlot*>> by_trigger;
  for (MapSlot& map : maps) {
    if (map.localize) {
      by_trigger[map.inputs.front()].push_back(&map);
    } else {
      map.share = 0.0;
    }
  }
  for (auto& [trigger, sharing] : by_trigger) {
    double sum = 0.0;
    for (MapSlot* map : sharing) {
      if (map->share == kShareNotGiven) map->share = 1.0 / static_cast<double>(sharing.size());
      sum += map->share;
    }
    if (sum > 1.0 + 1e-9) {
      yaml.fail(
          "maps",
          fmt::format("the information_share of maps with one trigger adds up to {}, at most 1 is consistent", sum));
    }
  }
}

}  // namespace waymark
