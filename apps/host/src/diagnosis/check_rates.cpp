// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kLeastSigmas = 4.0;

}  // namespace

void check_pull(Case& c, const Agreement& yaw) {
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const std::size_t sensor = yaw.observers[i].sensor;
    const double usual = 3.0 * yaw.observers[i].usual_curvature_per_m;
    if (c.sensor(sensor).role() != Role::wheels || c.is_blamed(sensor) || usual == 0.0) continue;
    int partners = 0;
    int pulling = 0;
    const Partner best = best_known(yaw, i, &Ratio::per_way_sigma, [&](const Ratio& ratio, std::size_t) {
      const bool is_alike = ratio.verdict == Ratio::Verdict::agree || std::abs(std::log(std::abs(ratio.value))) < 0.4;
      if (!is_alike || !(ratio.value > 0.0)) return false;
      ++partners;
      const bool pulls = std::abs(ratio.per_way) - usual >= kLeastSigmas * ratio.per_way_sigma;
      if (pulls) ++pulling;
      return pulls;
    });
    if (best.ratio == nullptr || 2 * pulling <= partners) continue;
    const double per_way = best.ratio->per_way;
    const double track = c.setting(sensor, "track_m");
    const double given = c.setting(sensor, "curvature_per_m");
    const double curvature = std::isfinite(given) ? given : 0.0;
    const std::string& name = c.sensor(sensor).name;
    c.add(Certainty::named, "wheels of unequal size", {sensor},
          fmt::format("it turns {:.3g} ± {:.2g} rad more per metre than {}", per_way, best.ratio->per_way_sigma,
                      c.sensor(best.sensor).name),
          std::isfinite(track)
              ? fmt::format("source: right_mps of {} times {:.3g} against left_mps", name, 1.0 - per_way * track)
              : fmt::format("sensors.{}.curvature_per_m: {:.3g} fits", name, curvature - per_way),
          (std::abs(per_way) - usual) / best.ratio->per_way_sigma);
  }
}

void check_gyro_offset(Case& c, const Agreement& yaw) {
  constexpr double kMostBias = 0.1;  // [rad/s], 6 °/s
  constexpr double kBiasSigmas = 6.0;
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const std::size_t sensor = yaw.observers[i].sensor;
    if (c.sensor(sensor).role() != Role::gyro || c.is_blamed(sensor)) continue;
    const Partner best = best_known(yaw, i, &Ratio::offset_sigma, [&](const Ratio& ratio, std::size_t other) {
      return other != sensor && ratio.verdict == Ratio::Verdict::agree;
    });
    if (best.ratio == nullptr) continue;
    const double offset = best.ratio->offset;
    const double estimated = c.sensor(sensor).usual.yaw_rate_bias_sigma_radps;
    const double most = std::isfinite(estimated) ? std::min(kMostBias, kBiasSigmas * estimated) : kMostBias;
    const double sigmas = beyond(offset, most, std::max(best.ratio->offset_sigma, 1e-6));
    if (sigmas < kLeastSigmas) continue;
    c.add(Certainty::named, "offset", {sensor},
          fmt::format("it turns {:.3g} ± {:.2g} rad/s more than {}, standing or not; a bias of no more than {:.2g} is "
                      "expected",
                      offset, best.ratio->offset_sigma, c.sensor(best.sensor).name, most),
          fmt::format("source: rates of {} less {:.4g} rad/s (the value at rest)", c.sensor(sensor).name, offset),
          sigmas);
  }
}

}  // namespace waymark::host::diagnosis
