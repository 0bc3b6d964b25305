// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fusion/inspection.hpp"
#include "unit/core/beliefs.hpp"
#include "waymark/host/fusion.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::test {

/// What an observer received after one measurement.
struct Seen {
  double stamp;
  std::uint32_t sensor;
  Fate fate;
  Belief belief;  ///< empty before the start
};

/// A host built from YAML with the real sensor plugins, and its snapshots.
class FusionRobot {
 public:
  explicit FusionRobot(const std::string& yaml, std::vector<std::pair<std::string, std::shared_ptr<Sensor>>> own = {},
                       std::vector<MapSlot> maps = {});

  Fusion& fusion() { return *fusion_; }
  /// The committed particles.
  const particles::ParticleFilter& filter() const { return fusion::Inspection::filter(*fusion_); }
  const std::vector<Seen>& seen() const { return seen_; }
  /// Plays a log that arrives in its order.
  FusionRobot& play(const std::vector<Measurement>& log);
  SensorReport report(std::size_t sensor) const;
  const Pose& pose() const;
  Eigen::Matrix3d pose_P() const;
  std::string events() const;
  std::string bytes() const;

 private:
  std::vector<Seen> seen_;
  std::unique_ptr<Fusion> fusion_;
};

Measurement reading(double stamp, std::uint32_t sensor, std::shared_ptr<const Payload> payload);

Measurement twist(double stamp, double v, double w = 0.0, std::uint32_t sensor = 0);

Measurement fix(double stamp, double east, double north, std::uint32_t sensor = 1);

/// Twists at `rate` from `from` to before `to`.
void drive(std::vector<Measurement>& log, double from, double to, double v, double w = 0.0, double rate = 10.0);

/// In the order of stamps (then sensors), with sequence numbers in that order: what a source delivers.
std::vector<Measurement> in_order(std::vector<Measurement> log);

/// Without errors as states of their own, and with little noise.
inline const std::string kNoStates = "speed_scale_sigma: 0, curvature_sigma_per_m: 0, yaw_scale_sigma: 0";
inline const std::string kNoScale = kNoStates + ", yaw_noise_rad_per_sqrt_s: [0, 0.01, 0.05]";
inline const std::string kWheels = "  - { name: wheels, plugin: odometry, model: twist, " + kNoScale + " }\n";
/// With white noise, unless `more` gives `offset_sigma_m`.
inline std::string gps(const std::string& more = "") {
  const bool has_offset = more.find("offset_sigma_m") != std::string::npos;
  return "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.1" +
         std::string(has_offset ? "" : ", offset_sigma_m: 0") + (more.empty() ? "" : ", " + more) + " }\n";
}
inline const std::string kAtOrigin =
    "initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 0, yaw_sigma_deg: 5 }\n";

}  // namespace waymark::test
