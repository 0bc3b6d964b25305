// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/sensor_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "waymark/math/gaussian.hpp"

namespace waymark {
namespace {

/// A factor in the variance that matters in practice: 1.4 in σ.
constexpr double kToleratedFactor = 2.0;
/// χ² of so many degrees of freedom is within 0.3 % of its expectation, and the quantile's argument is an int.
constexpr std::uint64_t kMostDof = 2'000'000;

std::string verdict_without_updates(const SensorReport& sensor) {
  if (sensor.measurements == 0) return "no measurements";
  if (sensor.held_out > 0) return "held out";
  if (sensor.mapped > 0) return "for maps";
  return "not used";
}

/// `is_for_maps`: its innovations are how far the predicted motion was from what the maps show.
std::string verdict_on(const SensorSummary& summary, bool is_motion_source, bool is_for_maps) {
  const double ratio = summary.nis_ratio;
  if (ratio > kToleratedFactor && ratio > summary.nis_high)
    return fmt::format("overconfident: {} {:.2g} times what σ predicts",
                       is_for_maps ? "poses in the map are off by" : "innovations are", std::sqrt(ratio));
  // Between two of its measurements next to nothing is known of the motion, so its innovations are small beside S.
  if (is_motion_source && ratio < 1.0) return "small, as of every motion source";
  if (!(ratio < 1.0 / kToleratedFactor && ratio < summary.nis_low)) return "consistent";
  // Beams share the errors of the map, so maps claim less than a scan alone determines.
  if (is_for_maps) return "small: the motion is no worse than σ predicts";
  return fmt::format("conservative: innovations are {:.2g} times what σ predicts", std::sqrt(ratio));
}

}  // namespace

SensorSummary summarize(const SensorReport& sensor) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  SensorSummary summary{.name = sensor.name,
                        .plugin = sensor.plugin,
                        .measurements = sensor.measurements,
                        .used = sensor.fused + sensor.mapped,
                        .rejected = sensor.gated + sensor.unusable,
                        .nis_ratio = kNone,
                        .nis_low = kNone,
                        .nis_high = kNone,
                        .verdict = {}};
  const double duration_s = to_seconds(sensor.last - sensor.first);
  if (sensor.measurements > 1 && duration_s > 0.0)
    summary.rate_hz = static_cast<double>(sensor.measurements - 1) / duration_s;
  if (sensor.nis_dof == 0 || !std::isfinite(sensor.nis_sum)) {
    summary.verdict = verdict_without_updates(sensor);
    return summary;
  }
  summary.nis_ratio = sensor.nis_sum / static_cast<double>(sensor.nis_dof);
  const auto dof = static_cast<int>(std::min(sensor.nis_dof, kMostDof));
  summary.nis_low = gaussian::chi_squared_quantile(0.025, dof) / dof;
  summary.nis_high = gaussian::chi_squared_quantile(0.975, dof) / dof;
  const bool is_for_maps = sensor.mapped > 0 && sensor.fused + sensor.gated == 0;
  summary.verdict = verdict_on(summary, sensor.is_motion_source, is_for_maps);
  return summary;
}

}  // namespace waymark
