// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::scan_matching {

/// What of a scan is used, and which scans are.
struct ScanSettings {
  double range_min;         ///< nearer returns are the robot itself [m]
  double range_max;         ///< farther returns are not used [m]
  double no_return;         ///< readings at or above this mean that nothing came back [m]
  double no_return_clears;  ///< such a beam is free up to here [m]; 0: it is not used
  double update_distance;   ///< a scan is taken when the robot has moved this far since the last one [m],
  double update_angle;      ///< or has turned by this much [rad],
  Duration update_after;    ///< or when so long has passed; 0: never for that reason

  /// Reads them from the map's node of the YAML. Throws ConfigError.
  static ScanSettings read(const Config& config, double resolution);
};

/// Matching on the likelihood field.
struct MatchSettings {
  static constexpr double kFartherTurns = 3.0;    ///< turns where nothing near fits, in coarse_angle
  static constexpr double kSearchStep = 0.75;     ///< of the coarse search, in wide_sigma
  static constexpr double kSearchYawStep = 0.03;  ///< [rad]
  double wide_sigma;                              ///< of the first stage [m]: the basin
  double narrow_sigma;                            ///< of the second [m]: the precision
  double curvature_scale;                         ///< κ: information of one squared residual
  double evidence_tempering;  ///< exponent of the scan's likelihood in the weight: beams are not independent
  double search_score;        ///< mean likelihood, 0..1, below which a better place is searched for
  double min_score;           ///< below which a match has failed
  int max_iterations;         ///< of each stage
  double coarse_distance;     ///< half width of the coarse search [m]
  double coarse_angle;        ///< [rad]
  int spread_draws;           ///< places looked at where the coarse search does not reach; 0: none
  Eigen::Vector3d floor;      ///< σ of (x [m], y [m], yaw [rad]) that is added to every match

  /// From the node `match`. Throws ConfigError.
  static MatchSettings read(const Config& config);
};

/// What hits and misses do, in steps of 1/kSteps.
struct OddsSettings {
  static constexpr double kSteps = 20.0;
  int hit;
  int miss;  ///< negative
  int low;
  int high;

  /// From the node `log_odds`. Throws ConfigError.
  static OddsSettings read(const Config& config);
};

}  // namespace waymark::scan_matching
