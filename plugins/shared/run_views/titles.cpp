// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/run_views/titles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace waymark::run_views {
namespace {

/// Decimals that two digits of a standard deviation need: 0 for 12, 2 for 0.11, 4 for 0.0042.
int decimals_of(double sigma) {
  if (!std::isfinite(sigma) || sigma <= 0.0) return 2;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9);
}

}  // namespace

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole >= 86'400) return fmt::format("{} d {:02} h", whole / 86'400, whole / 3600 % 24);
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{:.1f} s", seconds);
}

std::string date_text(Time stamp) {
  namespace chrono = std::chrono;
  if (stamp < Time{chrono::sys_days{chrono::year{1990} / chrono::January / 1}}) return {};
  const auto day = chrono::floor<chrono::days>(stamp);
  const chrono::year_month_day date{day};
  const auto minute = chrono::duration_cast<chrono::minutes>(stamp - day).count();
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02} UTC", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), minute / 60, minute % 60);
}

std::string sigma_text(double sigma) {
  if (sigma > 0.0 && sigma < 1e-9) return fmt::format("{:.1e}", sigma);
  return fmt::format("{:.{}f}", sigma, decimals_of(sigma));
}

std::string value_text(double value, double sigma) {
  return fmt::format("{:.{}f} ± {}", value, decimals_of(sigma), sigma_text(sigma));
}

}  // namespace waymark::run_views
