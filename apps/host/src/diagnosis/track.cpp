// SPDX-License-Identifier: Apache-2.0
#include "track.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace waymark::host::diagnosis {

namespace {

constexpr double kLeastGap = 0.6;   // [s], shorter ones are bridged
constexpr double kGapFactor = 3.5;  // usual intervals that are bridged
constexpr double kMemory = 0.05;    // of the usual interval, per sample
constexpr double kLongest = 1.5;    // [s], no longer interval is bridged
constexpr double kTouching = 0.02;  // [s], intervals that follow each other

}  // namespace

void Track::clear() {
  std::ranges::fill(stretches_, std::uint16_t{0});
  stretch_ = 0;
  last_ = -1.0;
  sum_ = last_rate_ = 0.0;
  samples_ = 0;
}

double Track::longest_gap() const { return std::clamp(kGapFactor * usual_, kLeastGap, kLongest); }

void Track::begin_stretch(double t) {
  if (sums_.empty()) {
    sums_.assign(kEdges, 0.0);
    stretches_.assign(kEdges, 0);
  }
  ++stretch_;
  last_ = t;
  const auto edge = static_cast<std::size_t>(std::ceil(t / kStep));
  if (edge < kEdges && static_cast<double>(edge) * kStep - t < 1e-9) {
    sums_[edge] = sum_;
    stretches_[edge] = stretch_;
  }
}

void Track::write(double from, double sum_from, double to, double sum_to) {
  const int first = std::max(0, static_cast<int>(std::floor(from / kStep)) + 1);
  const int last = std::min(kEdges - 1, static_cast<int>(std::floor(to / kStep)));
  for (int k = first; k <= last; ++k) {
    const auto edge = static_cast<std::size_t>(k);
    sums_[edge] = sum_from + (sum_to - sum_from) * (k * kStep - from) / (to - from);
    stretches_[edge] = stretch_;
  }
}

void Track::add_rate(double t, double rate) {
  if (!std::isfinite(rate) || t < 0.0 || (samples_ > 0 && t <= last_)) return;
  const double dt = t - last_;
  if (samples_ == 0 || dt > longest_gap()) {
    // The first interval shows the usual one.
    if (samples_ > 0 && usual_ == 0.0 && dt < kLongest) usual_ = dt;
    begin_stretch(t);
  } else {
    usual_ = usual_ == 0.0 ? dt : usual_ + kMemory * (dt - usual_);
    const double next = sum_ + 0.5 * (last_rate_ + rate) * dt;
    write(last_, sum_, t, next);
    sum_ = next;
    last_ = t;
  }
  last_rate_ = rate;
  ++samples_;
}

void Track::add_mean(double t, double interval, double rate) {
  if (!std::isfinite(rate) || !(interval > 0.0) || t < 0.0) return;
  if (samples_ == 0 || std::abs(t - last_) > kTouching) {
    if (samples_ > 0 && t < last_ - kTouching) return;
    begin_stretch(t);
  }
  usual_ = usual_ == 0.0 ? interval : usual_ + kMemory * (interval - usual_);
  const double next = sum_ + rate * interval;
  const double end = t + interval;
  if (end > last_) write(last_, sum_, end, next);
  sum_ = next;
  last_ = end;
  ++samples_;
}

void Track::add_total(double t, double total, bool is_angle) {
  if (!std::isfinite(total) || t < 0.0 || (samples_ > 0 && t <= last_)) return;
  const double dt = t - last_;
  const double turn = 2.0 * std::numbers::pi;
  const double next = is_angle ? sum_ + std::remainder(total - sum_, turn) : total;
  if (samples_ == 0 || dt > longest_gap()) {
    if (samples_ > 0 && usual_ == 0.0 && dt < kLongest) usual_ = dt;
    sum_ = next;
    begin_stretch(t);
  } else {
    usual_ = usual_ == 0.0 ? dt : usual_ + kMemory * (dt - usual_);
    write(last_, sum_, t, next);
    sum_ = next;
    last_ = t;
  }
  ++samples_;
}

std::optional<double> Track::at(double t) const {
  if (sums_.empty() || !(t >= 0.0) || t > kLength) return std::nullopt;
  const auto below = static_cast<std::size_t>(t / kStep);
  const std::size_t above = std::min<std::size_t>(below + 1, kEdges - 1);
  const double part = t / kStep - static_cast<double>(below);
  if (part < 1e-6) return stretches_[below] != 0 ? std::optional(sums_[below]) : std::nullopt;
  if (stretches_[below] == 0 || stretches_[below] != stretches_[above]) return std::nullopt;
  return sums_[below] + part * (sums_[above] - sums_[below]);
}

std::optional<double> Track::change(double from, double to) const {
  const std::optional<double> begin = at(from);
  const std::optional<double> end = at(to);
  if (!begin || !end) return std::nullopt;
  if (stretches_[static_cast<std::size_t>(from / kStep)] != stretches_[static_cast<std::size_t>(to / kStep)])
    return std::nullopt;
  return *end - *begin;
}

std::optional<double> Track::rate(double t, double half_window) const {
  const auto changed = change(t - half_window, t + half_window);
  return changed ? std::optional(*changed / (2.0 * half_window)) : std::nullopt;
}

void VectorTrack::clear() {
  for (Track& axis : axes_) axis.clear();
}

void VectorTrack::add_rate(double t, const Eigen::Vector3d& rate) {
  if (!rate.allFinite()) return;
  for (std::size_t i = 0; i < axes_.size(); ++i) axes_[i].add_rate(t, rate(static_cast<Eigen::Index>(i)));
}

std::optional<Eigen::Vector3d> VectorTrack::change(double from, double to) const {
  const auto x = axes_[0].change(from, to);
  const auto y = axes_[1].change(from, to);
  const auto z = axes_[2].change(from, to);
  return x && y && z ? std::optional(Eigen::Vector3d(*x, *y, *z)) : std::nullopt;
}

std::optional<Eigen::Vector3d> VectorTrack::rate(double t, double half_window) const {
  const auto changed = change(t - half_window, t + half_window);
  return changed ? std::optional<Eigen::Vector3d>(*changed / (2.0 * half_window)) : std::nullopt;
}

}  // namespace waymark::host::diagnosis
