// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "renderer.hpp"
#include "simulated_sensor.hpp"
#include "waymark/interface/rig.hpp"
#include "windows.hpp"

namespace waymark::simulator {

/// A colour camera that sees the world in perspective, under light that changes slowly, with noise in every pixel.
class SimulatedCamera : public SimulatedSensor {
 public:
  SimulatedCamera(const Config& config, const Rig& rig, const World& world);

 private:
  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;
  Light light(std::uint64_t seed, Duration stamp) const;

  Pose T_base_camera_;
  Intrinsics intrinsics_;
  double noise_sigma_;  // [grey levels of 255]
  double brightness_sigma_;
  double colour_sigma_;
  double lighting_time_s_;
  double sun_azimuth_rad_;
  double shading_;
  double exposure_gain_;
  double exposure_sigma_;
  double exposure_compensation_;
  Windows outages_;
  Windows black_;
  Windows overexposed_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<Eigen::Vector3f> pixels_;  // of the newest image; kept for its memory
};

}  // namespace waymark::simulator
