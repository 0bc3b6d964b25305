// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/measurement.hpp"

/// A payload of our own: the distance from an antenna on the robot to a radio beacon. Its name carries a version.
struct BeaconRange : waymark::PayloadOf<BeaconRange> {
  static constexpr std::string_view kType = "example/BeaconRange@1";
  double range_m = 0.0;

  /// The field, for checks and text formats.
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&BeaconRange::range_m, {.names = {"range_m"}, .unit = "m", .meaning = "distance to the beacon"});
  }
};
