// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/paper/representative.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

namespace waymark::paper {
namespace {

/// One way to fail: which trials do, and by what they are put in order to find the middle.
struct Failure {
  const char* figure;
  int scenario;
  const char* text;   ///< of those trials
  const char* order;  ///< name of the quantity
  std::function<bool(const Trial&)> is_so;
  std::function<double(const Trial&)> quantity;
};

/// Fig. 4.5: more landmarks than cylinders. A map of exactly twelve that is shifted is not that figure.
bool is_drawn_twice(const Trial& trial) { return trial.landmarks.counted > trial.landmarks.surveyed; }

/// Fig. 4.7: as many landmarks as cylinders at the end, after wrong associations or away from their cylinders.
bool is_offset(const Trial& trial) {
  return trial.landmarks.counted == trial.landmarks.surveyed &&
         (trial.associations.wrong > 0 || !trial.has_exact_map());
}

double landmarks_of(const Trial& trial) { return static_cast<double>(trial.landmarks.counted); }

std::vector<Failure> failures() {
  return {{"4.5", 2, "cylinders are drawn twice", "number of landmarks", is_drawn_twice, landmarks_of},
          {"4.7", 4, "as many landmarks as cylinders, but offset or after wrong associations", "RMS of the pose",
           is_offset, [](const Trial& trial) { return trial.position_rms_m; }}};
}

/// The scenario of that number, of the last filter of the experiment: the one as published, where there is one.
std::optional<std::size_t> scenario_of(const Experiment& experiment, int number) {
  std::optional<std::size_t> found;
  for (std::size_t s = 0; s < experiment.scenarios.size(); ++s) {
    if (experiment.scenarios[s].number == number) found = s;
  }
  return found;
}

}  // namespace

std::vector<Representative> representative_failures(const Results& results) {
  std::vector<Representative> chosen;
  if (results.experiment.name != "paper") return chosen;
  const auto& by_seed = results.trials[shown_noise(results)];
  for (const Failure& failure : failures()) {
    const std::optional<std::size_t> scenario = scenario_of(results.experiment, failure.scenario);
    if (!scenario) continue;
    std::vector<std::size_t> seeds;
    for (std::size_t k = 0; k < by_seed.size(); ++k) {
      if (failure.is_so(by_seed[k][*scenario])) seeds.push_back(k);
    }
    if (seeds.empty()) continue;
    std::ranges::stable_sort(seeds, {}, [&](std::size_t k) { return failure.quantity(by_seed[k][*scenario]); });
    const std::size_t seed = seeds[(seeds.size() - 1) / 2];
    const Trial& trial = by_seed[seed][*scenario];
    std::string picture = fmt::format("fig_{}.png", failure.figure);
    std::ranges::replace(picture.begin(), picture.end() - 4, '.', '_');
    chosen.push_back({failure.figure, std::move(picture),
                      fmt::format("{} landmarks, {} of {} cylinders found, {} wrong associations, pose {:.2f} m (RMS)",
                                  trial.landmarks.counted, trial.landmarks.matched, trial.landmarks.surveyed,
                                  trial.associations.wrong, trial.position_rms_m),
                      fmt::format("of the {} of {} seeds on which {}, the one in the middle by the {}", seeds.size(),
                                  by_seed.size(), failure.text, failure.order),
                      *scenario, seed});
  }
  return chosen;
}

}  // namespace waymark::paper
