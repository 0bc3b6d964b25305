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
constexpr double kShareNotGiven = -1.0;

std::vector<double> list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ProcessNoise read_process_noise(const Config& motion) {
  ProcessNoise noise;
  const auto velocity = motion.numbers("velocity_noise_mps_per_sqrt_s", 3, list(noise.velocity_per_sqrt_s));
  const auto rate = motion.numbers("rate_noise_radps_per_sqrt_s", 3, list(noise.rate_per_sqrt_s));
  for (int i = 0; i < 3; ++i) {
    if (velocity[static_cast<std::size_t>(i)] < 0.0) motion.fail("velocity_noise_mps_per_sqrt_s", "must be >= 0");
    if (rate[static_cast<std::size_t>(i)] < 0.0) motion.fail("rate_noise_radps_per_sqrt_s", "must be >= 0");
    noise.velocity_per_sqrt_s[i] = velocity[static_cast<std::size_t>(i)];
    noise.rate_per_sqrt_s[i] = rate[static_cast<std::size_t>(i)];
  }
  return noise;
}

StartSettings read_start(const Config& initial) {
  StartSettings start;
  if (initial.has("x_m") || initial.has("y_m"))
    start.position = Eigen::Vector2d(initial.number("x_m"), initial.number("y_m"));
  start.height = initial.number("z_m", 0.0);
  start.position_sigma = initial.non_negative("position_sigma_m", 0.0);
  if (initial.has("yaw_deg")) start.yaw = kRadPerDeg * initial.number_in("yaw_deg", -360.0, 360.0);
  start.yaw_sigma = kRadPerDeg * initial.number_in("yaw_sigma_deg", 0.0, 180.0, start.yaw ? 0.0 : 10.0);
  start.velocity_sigma = initial.positive("speed_sigma_mps", start.velocity_sigma);
  start.rate_sigma = initial.positive("rate_sigma_radps", start.rate_sigma);
  start.min_course_distance = initial.positive("min_course_distance_m", start.min_course_distance);
  return start;
}

FuseRule read_fuse_rule(const Config& entry) {
  FuseRule rule;
  const std::string mode = entry.choice("fuse", {"all", "start", "alternate", "stretches", "none"}, "all");
  if (mode == "start") rule.mode = FuseRule::Mode::start;
  if (mode == "none") rule.mode = FuseRule::Mode::none;
  // Read whatever the mode is: one file then serves all modes through a variable.
  rule.on = from_seconds(entry.positive("fuse_on_s", 10.0));
  rule.off = from_seconds(entry.positive("fuse_off_s", 10.0));
  rule.gap = from_seconds(entry.positive("fuse_gap_s", 1.0));
  if (mode == "alternate") rule.mode = FuseRule::Mode::alternate;
  if (mode == "stretches") rule.mode = FuseRule::Mode::stretches;
  return rule;
}

GeoreferenceSettings read_georeference(const Config& config) {
  GeoreferenceSettings georeference;
  georeference.enabled = config.boolean("enabled", georeference.enabled);
  georeference.position_walk_per_sqrt_m =
      config.non_negative("position_walk_m_per_sqrt_m", georeference.position_walk_per_sqrt_m);
  georeference.yaw_walk_per_sqrt_m =
      kRadPerDeg * config.non_negative("yaw_walk_deg_per_sqrt_m", georeference.yaw_walk_per_sqrt_m / kRadPerDeg);
  return georeference;
}

}  // namespace

FusionSettings read_fusion_settings(const Config& yaml) {
  FusionSettings settings;
  const Config motion = yaml.child_or_empty("motion");
  const std::string kind = motion.choice("kind", {"planar", "spatial"}, "planar");
  settings.motion = kind == "planar" ? StateLayout::Motion::planar : StateLayout::Motion::spatial;
  settings.process_noise = read_process_noise(motion);
  const bool old_name = motion.has("told_by") && !motion.has("source");
  if (old_name) settings.notices.emplace_back("motion.told_by is an old name: write motion.source");
  settings.motion_from_maps = motion.choice(old_name ? "told_by" : "source", {"sensors", "maps"}, "sensors") == "maps";
  settings.standstill_after = from_seconds(motion.positive("standstill_after_s", 0.5));

  settings.start = read_start(yaml.child_or_empty("initial"));
  if (yaml.has("datum")) {
    const Config datum = yaml.child("datum");
    settings.datum = Datum{datum.number_in("latitude_deg", -90.0, 90.0),
                           datum.number_in("longitude_deg", -180.0, 180.0), datum.number("height_m", 0.0)};
  }

  const Config filter = yaml.child_or_empty("filter");
  settings.filter.particles = static_cast<int>(filter.integer_in("particles", 1, 1'000'000, yaml.has("maps") ? 25 : 1));
  settings.filter.seed =
      static_cast<std::uint64_t>(filter.integer_in("seed", 0, std::numeric_limits<std::int64_t>::max(), 1));
  settings.filter.resample_threshold = filter.number_in("resample_threshold", 0.0, 1.0, 0.5);
  settings.filter.sampling_fraction = filter.number_in("sampling_fraction", 0.0, 1.0, 0.2);
  settings.filter.threads = static_cast<int>(filter.integer_in("threads", 1, 256, 1));
  settings.max_latency = from_seconds(filter.non_negative("max_latency_s", 0.0));
  settings.history = from_seconds(filter.number_in("history_s", 0.0, 600.0, 2.0));
  settings.smooth = filter.boolean("smooth", false);
  if (settings.smooth && yaml.has("maps")) filter.fail("smooth", "the smoother works without maps only");
  const Config clock = yaml.child_or_empty("clock");
  settings.clock.max_ahead = from_seconds(clock.non_negative("max_ahead_s", 0.1));
  settings.clock.max_jump = from_seconds(clock.positive("max_jump_s", 3600.0));
  const Config health = yaml.child_or_empty("health");
  settings.health.lost_sigma = health.positive("lost_sigma_m", 10.0);
  settings.health.unaided_after = from_seconds(health.positive("unaided_after_s", 10.0));
  settings.georeference = read_georeference(yaml.child_or_empty("georeference"));
  return settings;
}

namespace {

Intrinsics read_intrinsics(const Config& entry) {
  const auto positive = [&](std::string_view key) {
    std::vector<double> values = entry.numbers(key, 2);
    if (!(values[0] > 0.0) || !(values[1] > 0.0)) entry.fail(key, "two numbers > 0 are expected");
    return values;
  };
  const auto size = positive("size_px");
  if (size[0] != std::floor(size[0]) || size[1] != std::floor(size[1]) || size[0] > 65536 || size[1] > 65536)
    entry.fail("size_px", "two whole numbers up to 65536 are expected: width, height");
  const auto focal = positive("focal_px");
  const auto center = entry.numbers("center_px", 2);
  const auto distortion = entry.numbers("distortion", 5, {0.0, 0.0, 0.0, 0.0, 0.0});
  Intrinsics intrinsics{static_cast<int>(size[0]), static_cast<int>(size[1]), focal[0], focal[1], center[0], center[1]};
  std::ranges::copy(distortion, intrinsics.distortion.begin());
  return intrinsics;
}

}  // namespace

Mounting read_mounting(const Config& entry) {
  Mounting mounting;
  mounting.name = entry.text("name");
  mounting.payload = entry.text("payload", "");
  if (!mounting.payload.empty() && mounting.payload.find('/') == std::string::npos)
    mounting.payload = "waymark/" + mounting.payload + "@1";
  if (entry.has("base_T_sensor")) {
    const Config extrinsics = entry.child("base_T_sensor");
    const auto xyz = extrinsics.numbers("xyz_m", 3, {0.0, 0.0, 0.0});
    mounting.T_base_sensor = Pose{
        so3::from_rpy(kRadPerDeg * extrinsics.number("roll_deg", 0.0), kRadPerDeg * extrinsics.number("pitch_deg", 0.0),
                      kRadPerDeg * extrinsics.number("yaw_deg", 0.0)),
        {xyz[0], xyz[1], xyz[2]}};
  }
  if (entry.has("intrinsics")) mounting.intrinsics = read_intrinsics(entry.child("intrinsics"));
  return mounting;
}

SensorSlot read_sensor_slot(const Config& entry) {
  SensorSlot slot;
  slot.name = entry.text("name");
  slot.plugin = entry.text("plugin", "");
  slot.enabled = entry.boolean("enabled", true);
  slot.fuse = read_fuse_rule(entry);
  slot.gate_probability = entry.number_in("gate_probability", 0.5, 1.0 - 1e-12, 0.999);
  slot.weight_exponent = entry.number_in("weight_exponent", 0.0, 1.0, 1.0);
  slot.max_consecutive_rejections = static_cast<int>(entry.integer_in("max_consecutive_rejections", 0, 1'000'000, 20));
  slot.delay = from_seconds(entry.number_in("delay_s", -60.0, 60.0, 0.0));
  return slot;
}

MapSlot read_map_slot(const Config& entry, const Rig& rig) {
  MapSlot slot;
  slot.name = entry.text("name");
  slot.plugin = entry.text("plugin");
  for (const std::string& input : entry.texts("inputs")) {
    const int sensor = rig.find(input);
    if (sensor < 0) {
      std::string names;
      for (const Mounting& mounting : rig.mountings()) names += (names.empty() ? "" : ", ") + mounting.name;
      entry.fail("inputs", fmt::format("\"{}\" is no sensor of this file; there are: {}", input, names));
    }
    slot.inputs.push_back(sensor);
  }
  if (slot.inputs.empty()) entry.fail("inputs", "needs at least one sensor");
  slot.pair_max_age = from_seconds(entry.non_negative("pair_max_age_s", 0.15));
  slot.localize = entry.boolean("localize", true);
  slot.share = entry.has("information_share") ? entry.number_in("information_share", 0.0, 1.0) : kShareNotGiven;
  return slot;
}

void settle_shares(std::vector<MapSlot>& maps, const Config& yaml) {
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
