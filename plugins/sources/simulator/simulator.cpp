// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "course.hpp"
#include "layout.hpp"
#include "magnetism.hpp"
#include "placing.hpp"
#include "simulated_camera.hpp"
#include "simulated_gps.hpp"
#include "simulated_inertial.hpp"
#include "simulated_lidar.hpp"
#include "simulated_lidar_3d.hpp"
#include "simulated_wheels.hpp"
#include "surfaces_file.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/source.hpp"
#include "world.hpp"

namespace waymark::simulator {
namespace {

constexpr Duration kReferencePeriod{50'000'000};

DriveLimits read_limits(const Config& config) {
  DriveLimits limits{};
  limits.speed_mps = config.number_in("speed_mps", 0.01, 100.0, 1.0);
  limits.acceleration_mps2 = config.positive("acceleration_mps2", 0.5);
  limits.turn_rate_radps = config.positive("turn_rate_max_radps", 1.0);
  // A shorter look-ahead lets the robot circle around a point that it can never reach.
  const double shortest = 2.0 * limits.speed_mps / limits.turn_rate_radps;
  limits.lookahead_m = config.positive("lookahead_m", shortest);
  if (limits.lookahead_m < shortest) {
    config.fail("lookahead_m",
                fmt::format("{} is less than 2 speed_mps / turn_rate_max_radps = {}", limits.lookahead_m, shortest));
  }
  limits.slip_m_per_sqrt_s = config.non_negative("lateral_slip_m_per_sqrt_s", 0.0);
  return limits;
}

/// A robot on a course among cylinders. The whole motion is computed at the start, the measurements when they are asked
/// for.
class Simulator : public Source {
 public:
  Simulator(const Config& config, const Rig& rig)
      : duration_(from_seconds(config.number_in("duration_s", 0.1, 36000.0))),
        truth_(read_truth(config, duration_)),
        magnetism_(config.child_or_empty("magnetism"), truth_.world, truth_.seed) {
    if (config.has("wheels")) sensors_.push_back(std::make_unique<SimulatedWheels>(config.child("wheels")));
    if (config.has("gps")) sensors_.push_back(std::make_unique<SimulatedGps>(config.child("gps")));
    if (config.has("lidar")) sensors_.push_back(std::make_unique<SimulatedLidar>(config.child("lidar"), rig));
    if (config.has("lidar_3d"))
      sensors_.push_back(std::make_unique<SimulatedLidar3d>(config.child("lidar_3d"), rig, truth_.world));
    if (config.has("camera")) {
      sensors_.push_back(std::make_unique<SimulatedCamera>(config.child("camera"), rig, truth_.world));
    }
    if (config.has("imu")) sensors_.push_back(std::make_unique<SimulatedImu>(config.child("imu"), rig, magnetism_));
    if (config.has("compass")) {
      sensors_.push_back(std::make_unique<SimulatedCompass>(config.child("compass"), rig, magnetism_));
    }
    if (sensors_.empty()) {
      config.fail("no sensor: at least one of wheels, gps, lidar, lidar_3d, camera, imu, compass is expected");
    }
    for (const auto& sensor : sensors_) channels_.push_back(sensor->channel());
    reference_ = make_reference();
    if (config.has("surfaces_file")) surfaces_file_ = config.file().parent_path() / config.text("surfaces_file");
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
  static Truth read_truth(const Config& config, Duration duration) {
    const auto seed = static_cast<std::uint64_t>(config.integer("seed", 1));
    const Course course(config.child("course"));
    const DriveLimits limits = read_limits(config);
    // Only what stands somewhere needs to know where the robot drives; that takes a while to find out.
    const bool furnished =
        config.has("landmarks") || config.has("walls_m") || config.has("boxes_m") || config.has("clutter");
    World world = read_world(config, furnished ? nominal_path(course, limits) : Path{}, seed);
    return {drive(course, limits, duration, seed), std::move(world), seed};
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
