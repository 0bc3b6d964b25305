// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/random.hpp"

#include <cmath>
#include <numbers>

#include "math/philox.hpp"

namespace waymark {

Random::Random(const Key& key) {
  const std::uint64_t mixed = split_mix(split_mix(key.seed) ^ key.sensor);
  const auto stamp = static_cast<std::uint64_t>(key.stamp);
  key_ = {static_cast<std::uint32_t>(mixed), static_cast<std::uint32_t>(mixed >> 32)};
  counter_ = {0, key.slot, static_cast<std::uint32_t>(stamp), static_cast<std::uint32_t>(stamp >> 32)};
}

std::uint32_t Random::next() {
  if (used_ == 4) {
    block_ = philox(counter_, key_);
    ++counter_[0];
    used_ = 0;
  }
  return block_[static_cast<std::size_t>(used_++)];
}

double Random::uniform() {
  const std::uint64_t high = next();
  const std::uint64_t low = next();
  // 52 random bits and a half: the result is neither 0 nor 1.
  return (static_cast<double>(((high << 32) | low) >> 12) + 0.5) * 0x1p-52;
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace waymark
