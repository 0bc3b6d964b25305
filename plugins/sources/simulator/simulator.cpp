// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "course.hpp"
#include "ground.hpp"
#include "ground_plan.hpp"
#include "layout.hpp"
#include "magnetism.hpp"
#include "placing.hpp"
#include "simulated_beacons.hpp"
#include "simulated_camera.hpp"
#include "simulated_gps.hpp"
#include "simulated_inertial.hpp"
#include "simulated_lidar.hpp"
#include "simulated_lidar_3d.hpp"
#include "simulated_radar.hpp"
#include "simulated_wheels.hpp"
#include "surfaces_file.hpp"
#include "traffic.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/source.hpp"
#include "world.hpp"

namespace waymark::simulator {
namespace {

constexpr Duration kReferencePeriod{50'000'000};

DriveLimits read_limits(const Config& config) {
  DriveLimits limits{};
  limits.speed_mps = config.number_in({"speed_mps", "m/s", "cruising speed"}, 0.01, 100.0, 1.0);
  limits.speed_swing = config.number_in(
      {"speed_swing", "", "the cruising speed falls by this share and comes back, every 20 s"}, 0.0, 0.9, 0.0);
  limits.acceleration_mps2 = config.positive({"acceleration_mps2", "m/s²", "when starting and braking"}, 0.5);
  limits.turn_rate_radps = config.positive({"turn_rate_max_radps", "rad/s", "largest yaw rate"}, 1.0);
  // A shorter look-ahead lets the robot circle around a point that it can never reach.
  const double shortest = 2.0 * limits.speed_mps / limits.turn_rate_radps;
  limits.lookahead_m =
      config.positive({"lookahead_m", "m", "how far ahead the pursued point is; not less than the default",
                       "2 × speed_mps / turn_rate_max_radps"},
                      shortest);
  if (limits.lookahead_m < shortest) {
    config.fail("lookahead_m",
                fmt::format("{} is less than 2 speed_mps / turn_rate_max_radps = {}", limits.lookahead_m, shortest));
  }
  limits.slip_m_per_sqrt_s = config.non_negative(
      {"lateral_slip_m_per_sqrt_s", "m/√s", "the true robot drifts sideways at random while it moves"}, 0.0);
  limits.start_s = config.number_in(
      {"start_s", "s", "until then the robot stands on the first way point: time for an IMU to find its level"}, 0.0,
      36000.0, 0.0);
  return limits;
}

/// A robot on a course among cylinders. The whole motion is computed at the start, the measurements when they are asked
/// for.
class Simulator : public Source {
 public:
  Simulator(const Config& config, const Rig& rig)
      : duration_(from_seconds(config.number_in({"duration_s", "s", "length of the log"}, 0.1, 36000.0))),
        truth_(read_truth(config, duration_)),
        magnetism_(config.child_or_empty({"magnetism", "the magnetic field"}), truth_.world, truth_.seed),
        traffic_(config.child_or_empty({"traffic", "things that drive about; only radars see them"}), truth_.seed) {
    add_sensors(config, rig);
    if (sensors_.empty()) {
      config.fail(
          "no sensor: at least one of wheels, gps, lidar, lidar_3d, camera, imu, compass, radars, beacons is "
          "expected");
    }
    for (const auto& sensor : sensors_) channels_.push_back(sensor->channel());
    reference_ = make_reference();
    if (config.has("surfaces_file")) {
      surfaces_file_ =
          config.file().parent_path() /
          config.output({"surfaces_file", "",
                         "CSV that a run writes: the true surfaces, for `waymark evaluate --voxels … --surfaces`; "
                         "relative to the YAML. `kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m`: `cylinder` (centre, "
                         "radius), `box` and `wall` (from, to, half the thickness), `level` (ground, ceiling)",
                         "none"},
                        "");
    }
  }

  const std::vector<Channel>& channels() const override { return channels_; }

  std::optional<Measurement> next() override {
    // Here, so that who only looks at a configuration writes nothing.
    if (!surfaces_file_.empty())
      write_file(std::exchange(surfaces_file_, std::filesystem::path()), surfaces_csv(truth_.world));
    while (true) {
      const auto earliest = std::ranges::min_element(
          sensors_, {}, [&](const auto& sensor) { return sensor->next_arrival(truth_, duration_); });
      SimulatedSensor& sensor = **earliest;
      if (sensor.next_arrival(truth_, duration_) == Duration::max()) return std::nullopt;
      Sample sample = sensor.take(truth_);
      position_ = std::max(position_, sample.time);
      if (!sample.payload) continue;
      Measurement measurement;
      measurement.stamp = Time{sample.stamp};
      measurement.arrival = Time{sample.arrival};
      measurement.sensor = static_cast<std::uint32_t>(earliest - sensors_.begin());
      measurement.payload = std::move(sample.payload);
      measurement.sequence = sequence_++;
      return measurement;
    }
  }

  double progress() const override { return to_seconds(position_) / to_seconds(duration_); }

  std::shared_ptr<const Reference> reference() const override { return reference_; }

 private:
  void add_sensors(const Config& config, const Rig& rig) {
    const auto given = [&config](const Config::Key& key) {
      return config.has(key) ? std::optional<Config>(config.child(key)) : std::nullopt;
    };
    if (const auto wheels = given({"wheels", "wheel speeds (`WheelSpeeds`)"})) {
      sensors_.push_back(std::make_unique<SimulatedWheels>(*wheels));
    }
    if (const auto gps = given({"gps", "DGPS fixes in local metres (`GnssFix`)"})) {
      sensors_.push_back(std::make_unique<SimulatedGps>(*gps));
    }
    if (const auto lidar = given({"lidar", "planar scanner (`LaserScan`), at `base_T_sensor` of its `sensor`"})) {
      sensors_.push_back(std::make_unique<SimulatedLidar>(*lidar, rig));
    }
    if (const auto lidar = given({"lidar_3d", "3-D scanner (`PointCloud`), at `base_T_sensor` of its `sensor`"})) {
      sensors_.push_back(std::make_unique<SimulatedLidar3d>(*lidar, rig, truth_.world));
    }
    if (const auto camera = given(
            {"camera", "colour images (`Image`), from `base_T_sensor` of its `sensor`, which needs `intrinsics`"})) {
      sensors_.push_back(std::make_unique<SimulatedCamera>(*camera, rig, truth_.world));
    }
    if (const auto imu =
            given({"imu", "nine inertial and magnetic axes (`ImuSample`), at `base_T_sensor` of its `sensor`"})) {
      sensors_.push_back(std::make_unique<SimulatedImu>(*imu, rig, magnetism_));
    }
    if (const auto compass = given({"compass", "heading (`CompassHeading`), at `base_T_sensor` of its `sensor`"})) {
      sensors_.push_back(std::make_unique<SimulatedCompass>(*compass, rig, magnetism_));
    }
    const std::vector<Config> radars = config.items_or_empty(
        {"radars", "radars with Doppler (`RadarTargets`), each at `base_T_sensor` of its `sensor`"});
    if (radars.size() > SimulatedRadar::kMost) {
      config.fail("radars", fmt::format("{} radars; at most {} are expected", radars.size(), SimulatedRadar::kMost));
    }
    for (std::size_t i = 0; i < radars.size(); ++i)
      sensors_.push_back(std::make_unique<SimulatedRadar>(radars[i], rig, traffic_, i));
    if (const auto beacons = given({"beacons", "ranges to radio beacons (`Ranges`)"})) {
      sensors_.push_back(std::make_unique<SimulatedBeacons>(*beacons));
    }
  }

  static Truth read_truth(const Config& config, Duration duration) {
    const auto seed = static_cast<std::uint64_t>(config.integer({"seed", "of all noise"}, 1));
    const Course course(config.child({"course", "the way that the robot is driven"}));
    const DriveLimits limits = read_limits(config);
    const auto ground = std::make_shared<const Ground>(read_ground(config, seed));
    // Only what stands somewhere needs to know where the robot drives; that takes a while to find out.
    const bool furnished = config.has("landmarks") || config.has("walls_m") || config.has("boxes_m") ||
                           config.has("clutter") || config.has("floors");
    try {
      const auto uneven = ground->is_level() ? nullptr : ground;
      World world = read_world(config, *ground, furnished ? nominal_path(course, limits, uneven) : Path{}, seed);
      Trajectory trajectory = drive(course, limits, duration, seed);
      if (uneven) trajectory = trajectory.on(uneven, course.start_height_m());
      return {std::move(trajectory), std::move(world), seed};
    } catch (const std::domain_error& fall) {
      config.fail("course", fall.what());
    }
  }

  std::shared_ptr<const Reference> make_reference() const {
    auto reference = std::make_shared<Reference>();
    for (Duration time{0}; time <= duration_; time += kReferencePeriod) {
      reference->trajectory.push_back({Time{time}, truth_.trajectory.at(time).pose(), true});
    }
    const bool classes = truth_.world.textures.size() > truth_.world.kSurroundings + 1;
    for (const Cylinder& cylinder : truth_.world.landmarks) {
      std::string name = fmt::format("c{}", reference->landmarks.size() + 1);
      if (classes) name += fmt::format("_t{}", cylinder.texture);
      reference->landmarks.push_back({std::move(name), cylinder.center, cylinder.radius_m});
    }
    return reference;
  }

  Duration duration_;
  Truth truth_;
  Magnetism magnetism_;
  Traffic traffic_;
  std::vector<std::unique_ptr<SimulatedSensor>> sensors_;
  std::vector<Channel> channels_;
  std::shared_ptr<const Reference> reference_;
  std::filesystem::path surfaces_file_;  // empty: none, or already written
  std::uint64_t sequence_ = 0;
  Duration position_{0};  // when the newest of the delivered was measured
};

}  // namespace
}  // namespace waymark::simulator

WAYMARK_PLUGIN(waymark::Source, waymark::simulator::Simulator, "simulator", "1.0.0")
