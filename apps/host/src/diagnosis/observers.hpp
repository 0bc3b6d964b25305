// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "comparison.hpp"
#include "watch.hpp"

namespace waymark::host::diagnosis {

/// From one fix to another that lies well beyond their noise.
struct Chord {
  double from;
  double to;
  double length;
  double direction;  ///< counter-clockwise from east [rad]
};

/// Chords of a receiver's fixes, one after the other.
std::vector<Chord> chords_of(const std::vector<Fix>& fixes);

/// White noise of fixes per axis, from their second differences: motion is smooth, noise is not [m].
double noise_of(const std::vector<Fix>& fixes);

/// All that observe the robot's turning, and all that observe its way.
std::vector<Observer> yaw_observers(const Watch& watch);
std::vector<Observer> way_observers(const Watch& watch);

/// The first sensor that measures a signed way by itself; null if there is none.
const Track* measured_way(const Watch& watch);

}  // namespace waymark::host::diagnosis
