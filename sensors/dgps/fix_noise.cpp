// SPDX-License-Identifier: Apache-2.0
#include "fix_noise.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

namespace waymark::dgps {

namespace {

constexpr std::array<std::pair<GnssFix::Type, const char*>, 4> kTypes = {{{GnssFix::Type::single, "single"},
                                                                          {GnssFix::Type::differential, "differential"},
                                                                          {GnssFix::Type::rtk_float, "rtk_float"},
                                                                          {GnssFix::Type::rtk_fixed, "rtk_fixed"}}};

/// White part per axis of each type, in the open [m] (docs/math/dgps.md).
constexpr std::array<double, 4> kWhite = {0.5, 0.25, 0.1, 0.01};
/// The slow part of an error beside its white part, and both as shares of the whole.
constexpr double kSlowToWhite = 2.0;
constexpr double kWhiteShare = 0.45;
constexpr double kSlowShare = 0.9;

double white_of(GnssFix::Type type) {
  const auto* const found = std::ranges::find(kTypes, type, [](const auto& entry) { return entry.first; });
  return kWhite[static_cast<std::size_t>(found - kTypes.begin())];
}

GnssFix::Type read_receiver(const Config& config) {
  const std::string word = config.choice({"receiver", "class of the receiver, where a fix does not state its type"},
                                         {"single", "differential", "rtk_float", "rtk_fixed"}, "single");
  return std::ranges::find(kTypes, word, [](const auto& entry) { return std::string_view(entry.second); })->first;
}

}  // namespace

FixNoise::FixNoise(const Config& config)
    : receiver_(read_receiver(config)),
      has_sigma_(config.has("sigma_m")),
      has_slow_sigma_(config.has("offset_sigma_m")),
      // Only if they are there: an effective configuration must not give what followed from the class.
      sigma_(has_sigma_ ? config.positive({"sigma_m", "m",
                                           "white noise per horizontal axis; the floor, whatever the fix claims",
                                           "after the type of the fix: 0.5, 0.25, 0.1, 0.01"})
                        : kWhite.back()),
      usual_slow_(has_slow_sigma_ ? config.non_negative(
                                        {"offset_sigma_m", "m",
                                         "slowly varying error as a state of its own (first-order Gauss–Markov), so "
                                         "that repeated fixes do not count as independent; 0: none",
                                         "as large as `sigma_m` if that is given, else twice the white noise; with "
                                         "the quality of each fix"})
                                  : (has_sigma_ ? sigma_ : kSlowToWhite * white_of(receiver_))),
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
  if (use_reported_ && std::isfinite(fix.sigma_horizontal_m)) {
    // What a receiver reports is its whole error. Where the slow part of it is a state, only the rest is white.
    const double share = has_slow_sigma_ ? 1.0 : kWhiteShare;
    return std::max(sigma_, share * fix.sigma_horizontal_m);
  }
  return from_properties(fix);
}

double FixNoise::sigma_of_class(const GnssFix& fix) const {
  if (has_sigma_) return sigma_;
  const bool is_stated = fix.type != GnssFix::Type::unknown && fix.type != GnssFix::Type::none;
  return white_of(is_stated ? fix.type : receiver_);
}

double FixNoise::from_properties(const GnssFix& fix) const {
  double sigma = sigma_of_class(fix);
  if (sigma_per_hdop_ > 0.0 && std::isfinite(fix.hdop)) sigma = std::max(sigma, sigma_per_hdop_ * fix.hdop);
  sigma = std::max(sigma, sigma_by_type_[static_cast<std::size_t>(fix.type)]);
  if (fix.satellites >= 0 && fix.satellites < good_satellites_)
    sigma *= good_satellites_ / std::max(1.0, 1.0 * fix.satellites);
  return sigma;
}

double FixNoise::slow(const GnssFix& fix) const {
  if (has_slow_sigma_ || usual_slow_ == 0.0) return usual_slow_;
  const double beside_white = (has_sigma_ ? 1.0 : kSlowToWhite) * horizontal(fix);
  const bool is_reported = use_reported_ && std::isfinite(fix.sigma_horizontal_m);
  return is_reported ? std::max(beside_white, kSlowShare * fix.sigma_horizontal_m) : beside_white;
}

double FixNoise::vertical(const GnssFix& fix) const {
  if (use_reported_ && std::isfinite(fix.sigma_vertical_m)) return std::max(fix.sigma_vertical_m, sigma_vertical_);
  // Without a word of its own the height is as much worse than usual as the horizontal position is.
  return sigma_vertical_ * horizontal(fix) / sigma_;
}

}  // namespace waymark::dgps
