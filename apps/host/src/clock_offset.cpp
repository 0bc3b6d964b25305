// SPDX-License-Identifier: Apache-2.0
#include "clock_offset.hpp"

#include <cstddef>

namespace waymark::host {
namespace {

constexpr Duration kWindow = std::chrono::seconds(10);
constexpr std::size_t kMostWindows = 60;  // ten minutes

}  // namespace

void ClockOffset::add(Time stamp, Time arrival) {
  const double delay = 1e-9 * (static_cast<double>(arrival.time_since_epoch().count()) -
                               static_cast<double>(stamp.time_since_epoch().count()));
  if (windows_.empty() || arrival - windows_.back().begin >= kWindow) {
    windows_.push_back({arrival, arrival, delay});
    if (windows_.size() > kMostWindows) windows_.pop_front();
  } else if (delay < windows_.back().least_s) {
    windows_.back().at = arrival;
    windows_.back().least_s = delay;
  }
}

double ClockOffset::offset_s() const { return windows_.empty() ? 0.0 : -windows_.back().least_s; }

std::optional<Duration> ClockOffset::best_offset(const UsableOffsets& usable) const {
  std::optional<Duration> best;
  for (const Window& window : windows_) {
    const Duration offset = from_seconds(-window.least_s);
    if (usable.contains(offset) && (!best || offset > *best)) best = offset;
  }
  return best;
}

double ClockOffset::drift() const {
  if (windows_.size() < 3) return 0.0;
  // Least squares of the windows' least delays over time.
  const Time origin = windows_.front().at;
  double t_mean = 0.0;
  double d_mean = 0.0;
  for (const Window& w : windows_) {
    t_mean += to_seconds(w.at - origin);
    d_mean += w.least_s;
  }
  const auto n = static_cast<double>(windows_.size());
  t_mean /= n;
  d_mean /= n;
  double tt = 0.0;
  double td = 0.0;
  for (const Window& w : windows_) {
    const double t = to_seconds(w.at - origin) - t_mean;
    tt += t * t;
    td += t * (w.least_s - d_mean);
  }
  return tt > 0.0 ? -td / tt : 0.0;
}

}  // namespace waymark::host
