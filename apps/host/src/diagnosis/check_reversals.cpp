// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <vector>

#include "checks.hpp"
#include "dead_reckoning.hpp"
#include "observers.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Complex = std::complex<double>;

constexpr double kStep = 0.1;      // [s]
constexpr double kStill = 0.15;    // [m/s]
constexpr double kLeastWay = 1.0;  // [m] of a stretch
constexpr double kNoises = 5.0;    // σ of the fixes, at least
constexpr double kNear = 35.0 * kDegree;
constexpr std::size_t kLeastReversals = 2;

/// From the direction of dead reckoning to that of the fixes between two stops [rad].
std::optional<double> angle_of(const std::vector<Fix>& fixes, const DeadReckoning& path, double from, double to,
                               double least) {
  const auto first = std::ranges::lower_bound(fixes, from, {}, &Fix::t);
  auto last = std::ranges::upper_bound(fixes, to, {}, &Fix::t);
  if (last - first < 3) return std::nullopt;
  --last;
  const auto step = path.step(first->t, last->t);
  if (!step) return std::nullopt;
  const Eigen::Vector2d moved = last->p - first->p;
  const Complex driven = step->second.p - step->first.p;
  if (moved.norm() < least || std::abs(driven) < least) return std::nullopt;
  return std::arg(Complex(moved.x(), moved.y()) / driven);
}

std::vector<double> angles_of(const std::vector<Fix>& fixes, const DeadReckoning& path, const Track& way, double newest,
                              double least) {
  std::vector<double> angles;
  std::optional<double> begin;
  for (double t = 0.0; t < newest; t += kStep) {
    const auto driven = way.change(t, t + kStep);
    const bool moves = driven && std::abs(*driven) > kStill * kStep;
    if (moves && !begin) begin = t;
    if (moves || !begin) continue;
    if (const auto angle = angle_of(fixes, path, *begin, t, least)) angles.push_back(*angle);
    begin.reset();
  }
  return angles;
}

bool is_near(double a, double b) { return std::abs(so3::wrap(a - b)) < kNear; }

/// Stretches in which the fixes move against the way, while they move along it before and after.
std::size_t reversals(const std::vector<double>& angles) {
  std::size_t count = 0;
  for (std::size_t k = 1; k + 1 < angles.size(); ++k) {
    const double before = angles[k - 1];
    const double after = angles[k + 1];
    count += is_near(before, after) && is_near(angles[k], before + std::numbers::pi);
  }
  return count;
}

/// True for positions that go round the other way: mirrored, they show no reversals.
bool is_mirrored(const Agreement& yaw, std::size_t receiver) {
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    if (yaw.observers[i].sensor != receiver) continue;
    for (const Ratio& ratio : yaw.ratios[i]) {
      if (ratio.verdict == Ratio::Verdict::differ && ratio.value < 0.0) return true;
    }
  }
  return false;
}

}  // namespace

bool check_reversals(Case& c, const MotionAgreement& motion) {
  const auto way = std::ranges::find_if(motion.way.observers, [](const Observer& observer) {
    return observer.kind == Observer::Kind::measured && observer.track != nullptr;
  });
  if (way == motion.way.observers.end() || c.is_concerned(way->sensor)) return false;
  // Wheels that lose the sign of their speeds turn to the wrong side there, too.
  const Observer* turns = motion.yaw.trusted_track(&c.sensor(way->sensor).yaw);
  if (turns == nullptr || c.is_concerned(turns->sensor)) return false;
  const DeadReckoning path(*turns->track, *way->track, 0.0, 0.0, 0.0);
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& receiver = c.sensor(i);
    if (receiver.fixes.empty() || c.is_concerned(i) || i == way->sensor || is_mirrored(motion.yaw, i)) continue;
    const double least = std::max(kLeastWay, kNoises * noise_of(receiver.fixes));
    const std::size_t found = reversals(angles_of(receiver.fixes, path, *way->track, c.watch.newest(), least));
    if (found < kLeastReversals) continue;
    c.add(Finding::Certainty::named, "way", {way->sensor},
          fmt::format("it drives forwards in {} stretches in which {} goes backwards", found, receiver.name),
          fmt::format("source: the sign of the speed of {}, where the robot reverses", c.sensor(way->sensor).name),
          0.0);
    return true;
  }
  return false;
}

}  // namespace waymark::host::diagnosis
