// SPDX-License-Identifier: Apache-2.0
#include "texture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

Eigen::Vector3f bgr(double hue_deg, double saturation, double value) {
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue_deg / 60.0, 6.0);
    return static_cast<float>(value * (1.0 - saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0)));
  };
  return {channel(1.0), channel(3.0), channel(5.0)};
}

/// Smooth noise of mean 0 that repeats with the tile: random values on a grid of `cells` a side, interpolated.
std::vector<float> smooth_noise(std::size_t cells, Random& random) {
  std::vector<float> grid(cells * cells);
  for (float& value : grid) value = static_cast<float>(2.0 * random.uniform() - 1.0);
  const auto at = [&](std::size_t x, std::size_t y) { return grid[(y % cells) * cells + x % cells]; };
  std::vector<float> noise;
  noise.reserve(Tile::kSize * Tile::kSize);
  const float scale = static_cast<float>(cells) / static_cast<float>(Tile::kSize);
  for (std::size_t row = 0; row < Tile::kSize; ++row) {
    const float y = scale * static_cast<float>(row);
    const auto y0 = static_cast<std::size_t>(y);
    const float fy = y - static_cast<float>(y0);
    for (std::size_t column = 0; column < Tile::kSize; ++column) {
      const float x = scale * static_cast<float>(column);
      const auto x0 = static_cast<std::size_t>(x);
      const float fx = x - static_cast<float>(x0);
      const float upper = (1.0f - fx) * at(x0, y0) + fx * at(x0 + 1, y0);
      const float lower = (1.0f - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1);
      noise.push_back((1.0f - fy) * upper + fy * lower);
    }
  }
  return noise;
}

}  // namespace

std::vector<Texture> draw_textures(int count, std::uint64_t seed) {
  std::vector<Texture> textures;
  for (int i = 0; i < count; ++i) {
    Random random = stream(seed, Draw::textures, Duration{i});
    Texture texture;
    texture.hue_deg = std::fmod(30.0 + 360.0 * (i + 0.4 * (random.uniform() - 0.5)) / count, 360.0);
    if (texture.hue_deg < 0.0) texture.hue_deg += 360.0;
    texture.saturation = 0.45 + 0.4 * random.uniform();
    texture.value = 0.4 + 0.35 * random.uniform();
    texture.stripes = (i % 3) * 4 + static_cast<int>(4.0 * random.uniform());
    texture.stripe_contrast = 0.2 + 0.4 * random.uniform();
    texture.grain = 0.15 + 0.25 * random.uniform();
    texture.seed = seed + static_cast<std::uint64_t>(i);
    textures.push_back(texture);
  }
  return textures;
}

Tile::Tile(const Texture& texture) {
  const Eigen::Vector3f mean = bgr(texture.hue_deg, texture.saturation, texture.value);
  Random random = stream(texture.seed, Draw::grain, Duration{0});
  const std::vector<float> coarse = smooth_noise(6, random);
  const std::vector<float> medium = smooth_noise(24, random);
  const std::vector<float> fine = smooth_noise(96, random);
  std::vector<Eigen::Vector3f> finest;
  finest.reserve(kSize * kSize);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    const auto column = static_cast<double>(i % kSize) / static_cast<double>(kSize);
    const bool dark = texture.stripes > 0 && std::fmod(column * texture.stripes, 1.0) < 0.5;
    const double grain = texture.grain * (static_cast<double>(coarse[i]) + medium[i] + 0.6 * fine[i]);
    const double brightness = (1.0 + grain) * (dark ? 1.0 - texture.stripe_contrast : 1.0);
    finest.emplace_back(mean * static_cast<float>(std::max(brightness, 0.05)));
  }
  levels_.push_back(std::move(finest));
  for (std::size_t side = kSize / 2; side >= 1; side /= 2) {
    const std::vector<Eigen::Vector3f>& finer = levels_.back();
    std::vector<Eigen::Vector3f> level;
    level.reserve(side * side);
    for (std::size_t row = 0; row < side; ++row) {
      for (std::size_t column = 0; column < side; ++column) {
        const std::size_t upper = 4 * side * row + 2 * column;
        const std::size_t lower = upper + 2 * side;
        level.emplace_back(0.25f * (finer[upper] + finer[upper + 1] + finer[lower] + finer[lower + 1]));
      }
    }
    levels_.push_back(std::move(level));
  }
}

const Eigen::Vector3f& Tile::colour(double u, double v, double footprint) const {
  std::size_t level = 0;
  std::size_t side = kSize;
  for (double texels = footprint * static_cast<double>(kSize); texels > 1.5 && side > 1; texels *= 0.5) {
    ++level;
    side /= 2;
  }
  // The mask catches a fraction that rounding made 1.
  const auto texel = [&](double x) {
    return static_cast<std::size_t>((x - std::floor(x)) * static_cast<double>(side)) & (side - 1);
  };
  return levels_[level][texel(v) * side + texel(u)];
}

}  // namespace waymark::simulator
