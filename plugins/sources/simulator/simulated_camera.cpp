// SPDX-License-Identifier: Apache-2.0
#include "simulated_camera.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "streams.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::simulator {
namespace {

constexpr double kCameraPhase = 0.83;
constexpr double kOverexposure = 12.0;

/// SplitMix64 (G. Steele, D. Lea and C. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014). Philox
/// would take longer than the whole image.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// About standard normal, in steps of a quarter: the number of ones in 64 random bits has mean 32 and sigma 4.
float nearly_normal(std::uint64_t bits) { return 0.25f * static_cast<float>(std::popcount(bits) - 32); }

}  // namespace

SimulatedCamera::SimulatedCamera(const Config& config, const Rig& rig, const World& world)
    : SimulatedSensor(config, Image::kType, 10.0, kCameraPhase),
      T_base_camera_(rig.T_base_sensor(channel().sensor)),
      intrinsics_(rig.intrinsics(channel().sensor)),
      noise_sigma_(config.number_in({"noise_sigma", "of 255", "σ of each channel of each pixel"}, 0.0, 100.0, 2.0)),
      outages_(config, {"outages_s", "s", "begin, end of spans without image"}),
      black_(config, {"black_s", "s", "begin, end of spans with a black image"}),
      overexposed_(config, {"overexposed_s", "s", "begin, end of spans with a white image"}) {
  const Config lighting = config.child_or_empty({"lighting", "daylight"});
  brightness_sigma_ = lighting.number_in(
      {"brightness_sigma", "σ of the logarithm of daylight, which changes slowly: the next visit has another"}, 0.0,
      3.0, 0.15);
  colour_sigma_ = lighting.number_in(
      {"colour_sigma", "σ of the logarithm of red against green and of green against blue"}, 0.0, 1.0, 0.05);
  lighting_time_s_ =
      lighting.positive({"time_s", "s", "time after which the light has nothing to do with what it was"}, 60.0);
  sun_azimuth_rad_ =
      lighting.number_in({"sun_azimuth_deg", "°", "where the light comes from, counter-clockwise from east"}, -360.0,
                         360.0, -120.0) *
      kDegree;
  shading_ =
      lighting.number_in({"shading", "how much darker a surface is that faces away from the sun"}, 0.0, 1.0, 0.4);
  const Config exposure = config.child_or_empty({"exposure", "how the camera answers to the light"});
  exposure_gain_ = exposure.positive({"gain", "constant factor"}, 1.0);
  exposure_sigma_ = exposure.number_in({"sigma", "σ of the logarithm of each image's own factor"}, 0.0, 1.0, 0.02);
  exposure_compensation_ = exposure.number_in(
      {"compensation", "share of the changes of daylight that the exposure takes back"}, 0.0, 1.0, 0.5);
  if (T_base_camera_.p.z() <= 0.0) {
    config.fail("sensor", "base_T_sensor of '" + channel().sensor + "' is not above the ground, z = 0");
  }
  const char* refusal = Renderer::refusal(intrinsics_, T_base_camera_.q);
  if (*refusal != '\0') config.fail("sensor", "'" + channel().sensor + "': " + refusal);
  renderer_ = std::make_unique<Renderer>(intrinsics_, T_base_camera_.q, world.textures);
}

/// Daylight is a smooth random course: between knots of unit variance the weights cos and sin keep the variance.
Light SimulatedCamera::light(std::uint64_t seed, Duration stamp) const {
  const double time = to_seconds(stamp) / lighting_time_s_;
  const auto knot = static_cast<std::int64_t>(time);
  const double angle = 0.5 * std::numbers::pi * (time - static_cast<double>(knot));
  Random before = stream(seed, Draw::lighting, Duration{knot});
  Random after = stream(seed, Draw::lighting, Duration{knot + 1});
  const auto course = [&] { return std::cos(angle) * before.normal() + std::sin(angle) * after.normal(); };
  const double brightness = brightness_sigma_ * course();
  const double warmth = colour_sigma_ * course();

  const double flicker = exposure_sigma_ * stream(seed, Draw::exposure, stamp).normal();
  double gain = exposure_gain_ * std::exp((1.0 - exposure_compensation_) * brightness + flicker);
  if (overexposed_.contain(stamp)) gain *= kOverexposure;
  if (black_.contain(stamp)) gain = 0.0;
  const Eigen::Vector3d bgr(gain * std::exp(-warmth), gain, gain * std::exp(warmth));
  return {sun_azimuth_rad_, shading_, bgr.cast<float>()};
}

std::shared_ptr<Payload> SimulatedCamera::sample(const Truth& truth, Duration time) {
  if (outages_.contain(time)) return nullptr;
  const Pose T_map_camera = truth.trajectory.at(time).pose() * T_base_camera_;
  renderer_->render(truth.world, T_map_camera, light(truth.seed, time), pixels_);

  auto image = std::make_shared<Image>();
  image->encoding = Image::Encoding::bgr8;
  image->width = intrinsics_.width;
  image->height = intrinsics_.height;
  image->data.resize(3 * pixels_.size());
  auto counter = static_cast<std::uint64_t>(0x1p52 * stream(truth.seed, Draw::pixels, time).uniform());
  const auto sigma = static_cast<float>(noise_sigma_);
  std::uint8_t* out = image->data.data();
  for (const Eigen::Vector3f& pixel : pixels_) {
    for (int channel = 0; channel < 3; ++channel) {
      const float value = 255.0f * pixel[channel] + sigma * nearly_normal(mix(counter++)) + 0.5f;
      *out++ = static_cast<std::uint8_t>(std::clamp(value, 0.0f, 255.0f));
    }
  }
  return image;
}

}  // namespace waymark::simulator
