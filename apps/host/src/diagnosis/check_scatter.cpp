// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kTimes = 6.0;         // as large as its σ: a receiver of another class
constexpr double kAcceleration = 0.3;  // [m/s²], of a robot that is not known to drive steadily, as noise
constexpr std::size_t kLeastFixes = 60;

}  // namespace

void check_scatter(Case& c, std::size_t i, double scatter, double motion) {
  const WatchedSensor& sensor = c.sensor(i);
  const double sigma = sensor.usual.position_sigma_m;
  if (!(sigma > 0.0) || !std::isfinite(sigma) || sensor.fixes.size() < kLeastFixes || c.is_concerned(i)) return;
  if (scatter < kTimes * sigma + motion) return;
  c.add(Finding::Certainty::named, "noise", {i},
        fmt::format("its positions scatter by {:.2g} m from one to the next, {:.0f} times their sigma of {:.2g} m",
                    scatter, scatter / sigma, sigma),
        fmt::format("sensors.{}.sigma_m: {:.2g} fits, or a receiver of another class", sensor.name, scatter), 0.0);
}

void check_scatters(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.way.trusted_track();
  if (way != nullptr && !way->is_unsigned) return;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    if (sensor.fixes.size() < kLeastFixes) continue;
    const double interval = sensor.intervals.quantile(0.5);
    check_scatter(c, i, noise_of(sensor.fixes), kAcceleration * interval * interval);
  }
}

}  // namespace waymark::host::diagnosis
