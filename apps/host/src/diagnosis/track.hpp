// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace waymark::host::diagnosis {

/// A quantity that sums up over time (an angle turned, a way driven), sampled on a grid, so that its change between any
/// two times can be compared with that of another sensor. Stretches without measurements divide it: no change is known
/// across them. Memory is taken with the first sample.
class Track {
 public:
  static constexpr double kStep = 0.05;  ///< of the grid [s]
  static constexpr int kEdges = 8192;
  static constexpr double kLength = kStep * (kEdges - 1);  ///< of what it holds [s]

  /// Forgets everything; times count from the next window's begin.
  void clear();

  /// A rate at time t [s], linear between two of them.
  void add_rate(double t, double rate);
  /// The mean rate from t on for `interval` [s].
  void add_mean(double t, double interval, double rate);
  /// A total at time t; of an angle, it is unwrapped.
  void add_total(double t, double total, bool is_angle);

  /// Change from one time to a later one; nothing if it is not known throughout.
  std::optional<double> change(double from, double to) const;
  /// Mean change per second over so long before and after a time; nothing if it is not known throughout.
  std::optional<double> rate(double t, double half_window) const;
  /// The total at a time; nothing if it is not known.
  std::optional<double> at(double t) const;
  bool is_known(double t) const { return at(t).has_value(); }

  /// Share of the grid that is known, up to the newest time, and the newest time.
  double newest() const { return last_; }
  long samples() const { return samples_; }
  /// Usual time between two samples [s]; 0 while unknown.
  double interval() const { return usual_; }

 private:
  void write(double from, double sum_from, double to, double sum_to);
  void begin_stretch(double t);
  double longest_gap() const;

  std::vector<double> sums_;
  std::vector<std::uint16_t> stretches_;  // of each edge; 0: not known
  std::uint16_t stretch_ = 0;
  double last_ = -1.0;
  double sum_ = 0.0;
  double last_rate_ = 0.0;
  double usual_ = 0.0;
  long samples_ = 0;
};

/// A vector in the axes of the base, summed up over time.
class VectorTrack {
 public:
  void clear();
  void add_rate(double t, const Eigen::Vector3d& rate);

  const Track& x() const { return axes_[0]; }
  const Track& y() const { return axes_[1]; }
  const Track& z() const { return axes_[2]; }
  long samples() const { return axes_[0].samples(); }
  /// As those of a track.
  std::optional<Eigen::Vector3d> change(double from, double to) const;
  std::optional<Eigen::Vector3d> rate(double t, double half_window) const;

 private:
  std::array<Track, 3> axes_;
};

}  // namespace waymark::host::diagnosis
