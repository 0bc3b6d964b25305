// SPDX-License-Identifier: Apache-2.0
#include "fix_noise.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace waymark::dgps {

namespace {

constexpr std::array<std::pair<GnssFix::Type, const char*>, 4> kTypes = {{{GnssFix::Type::single, "single"},
                                                                          {GnssFix::Type::differential, "differential"},
                                                                          {GnssFix::Type::rtk_float, "rtk_float"},
                                                                          {GnssFix::Type::rtk_fixed, "rtk_fixed"}}};

}  // namespace

FixNoise::FixNoise(const Config& config)
    : sigma_(config.positive("sigma_m")),
      sigma_vertical_(config.positive("sigma_vertical_m", 2.0 * sigma_)),
      use_reported_(config.boolean("use_reported_sigma", true)),
      sigma_per_hdop_(config.non_negative("sigma_per_hdop_m", 0.0)),
      good_satellites_(static_cast<int>(config.integer_in("good_satellites", 0, 100, 0))) {
  const Config by_type = config.child_or_empty("sigma_by_type_m");
  for (const auto& [type, word] : kTypes) {
    if (by_type.has(word)) sigma_by_type_[static_cast<std::size_t>(type)] = by_type.positive(word);
  }
}

double FixNoise::horizontal(const GnssFix& fix) const {
  if (use_reported_ && std::isfinite(fix.sigma_horizontal_m)) return std::max(sigma_, fix.sigma_horizontal_m);
  double sigma = sigma_;
  if (sigma_per_hdop_ > 0.0 && std::isfinite(fix.hdop)) sigma = std::max(sigma, sigma_per_hdop_ * fix.hdop);
  sigma = std::max(sigma, sigma_by_type_[static_cast<std::size_t>(fix.type)]);
  if (fix.satellites >= 0 && fix.satellites < good_satellites_)
    sigma *= good_satellites_ / std::max(1.0, 1.0 * fix.satellites);
  return sigma;
}

double FixNoise::vertical(const GnssFix& fix) const {
  if (use_reported_ && std::isfinite(fix.sigma_vertical_m)) return std::max(fix.sigma_vertical_m, sigma_vertical_);
  // Without a word of its own the height is as much worse than usual as the horizontal position is.
  return sigma_vertical_ * horizontal(fix) / sigma_;
}

}  // namespace waymark::dgps
