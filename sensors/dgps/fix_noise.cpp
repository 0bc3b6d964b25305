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
    : sigma_(config.positive({"sigma_m", "m", "horizontal noise per axis; the floor, whatever the fix claims"})),
      sigma_vertical_(config.positive(
          {"sigma_vertical_m", "m",
           "vertical noise; grows with the horizontal one where the fix has no vertical σ of its own", "2 × `sigma_m`"},
          2.0 * sigma_)),
      use_reported_(
          config.boolean({"use_reported_sigma", "use the fix's own standard deviations where it has them"}, true)),
      sigma_per_hdop_(config.non_negative(
          {"sigma_per_hdop_m", "m", "where the fix has no σ of its own: noise at HDOP 1, multiplied by the HDOP"},
          0.0)),
      good_satellites_(
          static_cast<int>(config.integer_in({"good_satellites",
                                              "where the fix has no σ of its own: with n satellites, fewer than these, "
                                              "the noise is multiplied by `good_satellites`/n"},
                                             0, 100, 0))) {
  const Config by_type = config.child_or_empty({"sigma_by_type_m", "",
                                                "where the fix has no σ of its own: least noise by fix type, as in `{ "
                                                "single: 3, differential: 0.5, rtk_float: 0.3, rtk_fixed: 0.02 }`",
                                                "none"});
  for (const auto& [type, word] : kTypes) {
    if (by_type.has(word)) {
      sigma_by_type_[static_cast<std::size_t>(type)] =
          by_type.positive({word, "m", "least noise of a fix of this type", "none"});
    }
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
