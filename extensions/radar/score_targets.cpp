// SPDX-License-Identifier: Apache-2.0
// score_targets FILE [KEYS]: what the sensor `radar` takes for standing still and for moving in a recording with
// labels.
//   score_targets targets.bin.gz
//   score_targets radar.csv.gz '{ dimensions: 3, min_range_m: 0.3 }'      # keys of the sensor
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "ego_velocity.hpp"
#include "radar_settings.hpp"
#include "targets_file.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/config.hpp"

namespace waymark::radar {

namespace {

/// Counts of one radar.
struct Scans {
  std::size_t all = 0, believed = 0, used = 0, inliers = 0;
  double speed_sum_mps = 0.0, speed_max_mps = 0.0;
};

/// Counts of one label, within scans that are believed.
struct Targets {
  std::size_t all = 0, moving = 0;
};

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

void score(const std::string& file, const ScanSettings& settings) {
  const auto recording = TargetsFile::open(file);
  EgoVelocityEstimator estimator(settings);
  std::map<int, Scans> radars;
  std::map<int, Targets> labels;
  while (const std::optional<Scan> scan = recording->next()) {
    const Random random({0, 0, scan->stamp.time_since_epoch().count(), static_cast<std::uint32_t>(scan->radar)});
    const EgoVelocity velocity = estimator.estimate(scan->targets, random);
    Scans& radar = radars[scan->radar];
    ++radar.all;
    if (!estimator.believed(velocity)) continue;
    ++radar.believed;
    radar.used += velocity.used;
    radar.inliers += velocity.inliers;
    radar.speed_sum_mps += velocity.v.norm();
    radar.speed_max_mps = std::max(radar.speed_max_mps, velocity.v.norm());
    for (std::size_t i = 0; i < scan->labels.size(); ++i) {
      Targets& targets = labels[scan->labels[i]];
      ++targets.all;
      if (estimator.stands_still()[i] == 0) ++targets.moving;
    }
  }
  for (const auto& [number, r] : radars) {
    std::printf(
        "radar %d: %zu scans, %.2f %% with a velocity, %.1f %% of their targets stand still, speed mean %.3f m/s, max "
        "%.3f m/s\n",
        number, r.all, percent(r.believed, r.all), percent(r.inliers, r.used),
        r.speed_sum_mps / static_cast<double>(std::max<std::size_t>(1, r.believed)), r.speed_max_mps);
  }
  for (const auto& [label, t] : labels) {
    std::printf("label %d: %zu targets, %.1f %% taken for moving\n", label, t.all, percent(t.moving, t.all));
  }
}

int run(const std::vector<std::string>& words) {
  if (words.empty() || words.size() > 2) {
    std::fputs("usage: score_targets FILE ['{ key: value, … }']\n", stderr);
    return 2;
  }
  try {
    const Config config = Config::parse(words.size() == 2 ? words[1] : "{}", "keys");
    const RadarSettings settings = RadarSettings::read(config);
    config.reject_unread();
    score(words[0], settings.scan);
  } catch (const Error& error) {
    std::fprintf(stderr, "score_targets: error: %s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace waymark::radar

int main(int count, char** arguments) { return waymark::radar::run({arguments + 1, arguments + count}); }
