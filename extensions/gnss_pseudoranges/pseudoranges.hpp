// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "waymark/interface/measurement.hpp"

namespace waymark::gnss {

/// The pseudoranges of one epoch: `Ranges@1` does not fit, since its beacons stand still.
struct Pseudoranges : PayloadOf<Pseudoranges> {
  static constexpr std::string_view kType = "gnss/Pseudoranges@1";
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  /// One satellite.
  struct One {
    int system = 0;
    int number = 0;
    double range_m = 0.0;
    Eigen::Vector3d p_ecef_m = Eigen::Vector3d::Zero();
    double cn0_dbhz = kUnknown;
    double sigma_m = kUnknown;

    template <class Visitor>
    static void fields(Visitor&& field) {
      field(&One::system,
            {.names = {"system"}, .meaning = "number of the satellite's system, each with a time of its own"});
      field(&One::number, {.names = {"number"}, .meaning = "number of the satellite", .required = false});
      field(&One::range_m, {.names = {"range_m"},
                            .unit = "m",
                            .meaning = "pseudorange, corrected for the satellite's clock and the atmosphere"});
      field(&One::p_ecef_m, {.names = {"x_m", "y_m", "z_m"},
                             .unit = "m",
                             .meaning = "the satellite when it transmitted, fixed to the Earth at that time (ECEF)"});
      field(&One::cn0_dbhz, {.names = {"cn0_dbhz"},
                             .unit = "dBHz",
                             .meaning = "carrier to noise density",
                             .required = false,
                             .unknown = "NaN"});
      field(&One::sigma_m, {.names = {"sigma_m"},
                            .unit = "m",
                            .meaning = "its σ, as the receiver reports it",
                            .required = false,
                            .unknown = "NaN"});
    }
  };
  std::vector<One> satellites;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Pseudoranges::satellites, {.names = {"satellites"}, .meaning = "may be empty"});
  }
  std::string_view contradiction() const {
    for (const One& one : satellites) {
      if (one.p_ecef_m.norm() < 1e6) return "a satellite is within the Earth";
    }
    return {};
  }
};

}  // namespace waymark::gnss
