// SPDX-License-Identifier: Apache-2.0
#include "ground.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace waymark::simulator {
namespace {

constexpr double kThreshold = 0.01;  // [m], what a wheel climbs
constexpr double kSeam = 1e-6;       // [m], between decks that touch
constexpr double kOnSurface = 1e-7;  // [m]
constexpr double kFarthest = 1e4;    // [m]
constexpr int kMostSteps = 10'000;

/// Where a ray is over a deck.
struct Over {
  double enter;
  double leave;
};

/// Cuts the interval down to where |at + t·rate| <= half.
void cut(double at, double rate, double half, Over& over) {
  if (std::abs(rate) < 1e-12) {
    if (std::abs(at) > half) over.leave = -std::numeric_limits<double>::infinity();
    return;
  }
  const double a = (-half - at) / rate;
  const double b = (half - at) / rate;
  over = {std::max(over.enter, std::min(a, b)), std::min(over.leave, std::max(a, b))};
}

/// Walks along a ray that starts above a surface, in steps too short to pass through it. `clearance(t)` is the height
/// above the surface, which falls by at most `fastest` per metre. `end` if it meets nothing before.
template <class Clearance>
double walk(double begin, double end, double fastest, const Clearance& clearance) {
  double t = begin;
  for (int step = 0; step < kMostSteps && t <= end; ++step) {
    const double left = clearance(t);
    if (left < kOnSurface) return t;
    t += left / fastest;
  }
  return end;
}

double across(const Deck& deck, const Eigen::Vector2d& v) { return deck.along.x() * v.y() - deck.along.y() * v.x(); }

}  // namespace

bool Deck::covers(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d v = p - from;
  const double s = v.dot(along);
  return s >= -kSeam && s <= length_m + kSeam && std::abs(across(*this, v)) <= half_width_m + kSeam;
}

double Deck::height(double s) const {
  const double slope = steepest();
  const double to_end = length_m - s;
  if (s <= 0.0) return from_m;
  if (to_end <= 0.0) return to_m;
  if (s < rounding_m) return from_m + 0.5 * slope * s * s / rounding_m;
  if (to_end < rounding_m) return to_m - 0.5 * slope * to_end * to_end / rounding_m;
  return from_m + slope * (s - 0.5 * rounding_m);
}

Ground::Ground(std::vector<Deck> decks, std::vector<Wave> waves) : decks_(std::move(decks)), waves_(std::move(waves)) {
  for (const Wave& wave : waves_) {
    highest_wave_m_ += wave.amplitude_m;
    steepest_wave_ += wave.amplitude_m * wave.k.norm();
  }
}

double Ground::waves_at(const Eigen::Vector2d& p) const {
  double z = 0.0;
  for (const Wave& wave : waves_) z += wave.amplitude_m * std::sin(wave.k.dot(p) + wave.phase_rad);
  return z;
}

Slope Ground::at(int deck, const Eigen::Vector2d& p) const {
  Slope out;
  if (deck != kLowest) {
    const Deck& d = decks_[static_cast<std::size_t>(deck)];
    const double s = (p - d.from).dot(d.along);
    const double inside = std::min(s, d.length_m - s);
    const double full = d.steepest();
    const double slope = full * std::clamp(inside / d.rounding_m, 0.0, 1.0);
    const bool bends = inside > 0.0 && inside < d.rounding_m;
    const double bend = bends ? std::copysign(1.0, 0.5 * d.length_m - s) * full / d.rounding_m : 0.0;
    out = {d.height(s),
           slope * d.along.x(),
           slope * d.along.y(),
           bend * d.along.x() * d.along.x(),
           bend * d.along.x() * d.along.y(),
           bend * d.along.y() * d.along.y()};
  }
  for (const Wave& wave : waves_) {
    const double angle = wave.k.dot(p) + wave.phase_rad;
    const double sine = wave.amplitude_m * std::sin(angle);
    const double cosine = wave.amplitude_m * std::cos(angle);
    out.z += sine;
    out.z_x += cosine * wave.k.x();
    out.z_y += cosine * wave.k.y();
    out.z_xx -= sine * wave.k.x() * wave.k.x();
    out.z_xy -= sine * wave.k.x() * wave.k.y();
    out.z_yy -= sine * wave.k.y() * wave.k.y();
  }
  return out;
}

std::optional<int> Ground::below(const Eigen::Vector2d& p, double z) const {
  const double waves = waves_at(p);
  const double reach = z + kThreshold - waves;
  int best = kLowest;
  double highest = 0.0;
  for (std::size_t i = 0; i < decks_.size(); ++i) {
    const Deck& deck = decks_[i];
    if (!deck.covers(p)) continue;
    const double top = deck.height((p - deck.from).dot(deck.along));
    if (top > reach) {
      if (deck.base_m < reach) return std::nullopt;
    } else if (top >= highest) {
      best = static_cast<int>(i);
      highest = top;
    }
  }
  return best;
}

double Ground::cast_deck(const Deck& deck, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                         double nearest) const {
  const Eigen::Vector2d v = origin.head<2>() - deck.from;
  const double s = v.dot(deck.along);
  const double ds = direction.head<2>().dot(deck.along);
  Over over{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  cut(s - 0.5 * deck.length_m, ds, 0.5 * deck.length_m, over);
  cut(across(deck, v), across(deck, direction.head<2>()), deck.half_width_m, over);
  const double begin = std::max(over.enter, 0.0);
  const double end = std::min(over.leave, nearest);
  if (begin > end) return nearest;

  const auto clearance = [&](double t) {
    const double waves = waves_.empty() ? 0.0 : waves_at(origin.head<2>() + t * direction.head<2>());
    return origin.z() + t * direction.z() - deck.height(s + t * ds) - waves;
  };
  const double z = origin.z() + begin * direction.z();
  if (z < deck.base_m) {
    const double to_base = (deck.base_m - origin.z()) / direction.z();
    return direction.z() > 0.0 && to_base <= end ? to_base : nearest;
  }
  if (clearance(begin) <= 0.0) return begin;
  const double fastest =
      std::abs(direction.z()) + std::abs(ds * deck.steepest()) + direction.head<2>().norm() * steepest_wave_;
  const double met = walk(begin, std::min(end, kFarthest), fastest, clearance);
  return met < end ? met : nearest;
}

double Ground::cast_lowest(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double nearest) const {
  if (waves_.empty()) {
    const double distance = -origin.z() / direction.z();
    return distance >= 0.0 ? std::min(nearest, distance) : nearest;  // false for NaN: the ray lies in the plane
  }
  const double above = origin.z() - highest_wave_m_;
  if (above > 0.0 && direction.z() >= 0.0) return nearest;
  const double begin = above > 0.0 ? -above / direction.z() : 0.0;
  const double end = std::min(nearest, kFarthest);
  const double fastest = std::abs(direction.z()) + direction.head<2>().norm() * steepest_wave_;
  const double met = walk(begin, end, fastest, [&](double t) {
    return origin.z() + t * direction.z() - waves_at(origin.head<2>() + t * direction.head<2>());
  });
  return met < end ? met : nearest;
}

double Ground::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, bool with_lowest,
                    double nearest) const {
  if (with_lowest) nearest = cast_lowest(origin, direction, nearest);
  for (const Deck& deck : decks_) nearest = cast_deck(deck, origin, direction, nearest);
  return nearest;
}

}  // namespace waymark::simulator
