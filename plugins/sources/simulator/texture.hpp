// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace waymark::simulator {

/// What a surface looks like: a mean colour, stripes across the horizontal and irregular grain.
struct Texture {
  double hue_deg = 0.0;          ///< 0 to 360
  double saturation = 0.0;       ///< 0 to 1
  double value = 0.5;            ///< 0 to 1
  int stripes = 0;               ///< vertical stripes in one tile
  double stripe_contrast = 0.0;  ///< 0 to 1, how much darker a stripe is
  double grain = 0.0;            ///< 0 to 1, how much brightness varies irregularly
  std::uint64_t seed = 0;        ///< of the grain
};

/// `count` textures, drawn so that hue and pattern of any two differ.
std::vector<Texture> draw_textures(int count, std::uint64_t seed);

/// A texture painted on a square that repeats in both directions, at every coarseness, so that a far surface does not
/// flicker.
class Tile {
 public:
  static constexpr std::size_t kSize = 256;  ///< texels along one side of the finest level

  explicit Tile(const Texture& texture);

  /// Blue, green, red (0 to 1) at (u, v), where a tile has side 1. `footprint` is the side of the pixel on the surface
  /// in the same unit; detail finer than that is averaged.
  const Eigen::Vector3f& colour(double u, double v, double footprint) const;

 private:
  std::vector<std::vector<Eigen::Vector3f>> levels_;  // level k has side kSize / 2^k; the last one texel
};

}  // namespace waymark::simulator
