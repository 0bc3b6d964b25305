// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "track.hpp"

namespace waymark::host::diagnosis {

/// What a robot drives in the axes of its base.
struct Way {
  Way(const Track& forwards_track, const Track* left_track = nullptr, double times = 1.0)  // NOLINT: most only drive on
      : forwards(forwards_track), left(left_track), left_scale(times) {}

  const Track& forwards;
  const Track* left;  ///< null: it moves forwards only
  double left_scale;  ///< so many times as far to the left as `left` says
};

/// The way that turns and ways add up to, on the grid of the tracks, in a frame of its own.
class DeadReckoning {
 public:
  /// `per_way` is the yaw's turn per way that is to be taken out [rad/m], and `per_s` its bias [rad/s]. `late`: by so
  /// much the stamps of the way are behind those of the yaw [s].
  DeadReckoning(const Track& yaw, const Way& way, double per_way, double per_s, double late);

  struct Point {
    std::complex<double> p;  ///< x + iy [m]
    double yaw = 0.0;        ///< [rad]
  };
  /// Both ends of a step; nothing if it is not known throughout.
  std::optional<std::pair<Point, Point>> step(double from, double to) const;

 private:
  static std::size_t index(double t) { return static_cast<std::size_t>(t / Track::kStep); }
  std::optional<Point> at(double t) const;

  std::vector<Point> points_;
  std::vector<int> stretch_;
};

}  // namespace waymark::host::diagnosis
