// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string_view>

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

/// What a kind of matching takes if the YAML says nothing; the texts as for `Config::Key::fallback`.
struct MatchDefaults {
  double wide_sigma;  ///< [m]
  std::string_view wide_sigma_text;
  double narrow_sigma;  ///< [m]
  std::string_view narrow_sigma_text;
  double search_score;
  double min_score;

  /// On the likelihood field of cells. A narrow field that is wider is pulled ahead, onto surfaces whose near side is
  /// worn away.
  static MatchDefaults cells(double resolution) {
    return {.wide_sigma = std::max(0.12, 1.2 * resolution),
            .wide_sigma_text = "the larger of 0.12 and 1.2 * resolution_m",
            .narrow_sigma = 0.7 * resolution,
            .narrow_sigma_text = "0.7 * resolution_m",
            .search_score = 0.5,
            .min_score = 0.25};
  }
  /// On small planes.
  static MatchDefaults planes() {
    return {.wide_sigma = 0.12,
            .wide_sigma_text = {},
            .narrow_sigma = 0.05,
            .narrow_sigma_text = {},
            .search_score = 0.6,
            .min_score = 0.3};
  }
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
  static MatchSettings read(const Config& config, const MatchDefaults& defaults);
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
