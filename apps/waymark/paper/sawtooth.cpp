// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/paper/sawtooth.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>

#include "apps/waymark/paper/spread.hpp"

namespace waymark::paper {
namespace {

constexpr std::array<int, 2> kParticles{1, 25};

struct Filter {
  const char* title;
  const char* text;
};

constexpr std::array<Filter, 3> kFilters{
    {{"The paper's filter", "Every fix counts as independent of the others, with the σ of its white noise."},
     {"With the slowly varying error as states", "`offset_sigma_m` and `offset_tau_s` as in the simulator."},
     {"With the map's place on the Earth as states", "`georeference`: the default of this program."}}};

/// Every cylinder once and nothing else, wherever the map as a whole has been pulled to.
bool is_consistent(const Trial& trial) {
  return trial.landmarks.counted == trial.landmarks.surveyed && trial.associations.wrong == 0;
}

/// The criterion of the scenarios of §4.4: also in its place.
bool is_right_in_place(const Trial& trial) { return trial.has_exact_map() && trial.associations.wrong == 0; }

std::vector<Trial> trials_of(const std::vector<std::vector<Trial>>& by_seed, std::size_t scenario) {
  std::vector<Trial> trials;
  trials.reserve(by_seed.size());
  for (const std::vector<Trial>& seed : by_seed) trials.push_back(seed[scenario]);
  return trials;
}

using Cell = std::function<std::string(const std::vector<Trial>&)>;

std::string share(const std::vector<Trial>& trials, bool (*condition)(const Trial&)) {
  const auto good = static_cast<double>(std::ranges::count_if(trials, condition));
  return fmt::format("{:.0f} %", 100.0 * good / static_cast<double>(trials.size()));
}

std::string position_rms(const std::vector<Trial>& trials) {
  std::vector<double> values(trials.size());
  std::ranges::transform(trials, values.begin(), &Trial::position_rms_m);
  return spread(values, 2);
}

/// Rates down, errors across; in each cell one particle, then 25.
std::string table(const Sawtooth& results, std::size_t filter, const Cell& cell) {
  std::string text = "| GPS |";
  std::string rule = "|---|";
  for (const double error : Sawtooth::kErrors) {
    text += fmt::format(" {:g} m |", error);
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  const auto both = [&](std::size_t gps) {
    const auto& by_seed = results.trials[gps];
    return fmt::format("{}, {}", cell(trials_of(by_seed, 2 * filter)), cell(trials_of(by_seed, 2 * filter + 1)));
  };
  std::size_t gps = 1;
  for (const double rate : Sawtooth::kRates) {
    text += fmt::format("| {:g} Hz |", rate);
    for ([[maybe_unused]] const double error : Sawtooth::kErrors) text += fmt::format(" {} |", both(gps++));
    text += "\n";
  }
  return text + fmt::format("\nWithout GPS: {}.\n", both(0));
}

}  // namespace

Sawtooth Sawtooth::prepare(int seeds) {
  Sawtooth results;
  for (int seed = 1; seed <= seeds; ++seed) results.seeds.push_back(static_cast<std::uint64_t>(seed));
  results.gps.push_back({0.0, 0.0});
  for (const double rate : kRates) {
    for (const double error : kErrors) results.gps.push_back({rate, error});
  }
  results.trials.assign(results.gps.size(), std::vector<std::vector<Trial>>(results.seeds.size()));
  return results;
}

std::vector<Scenario> Sawtooth::scenarios(const Gps& gps) {
  const std::array<std::vector<std::string>, kFilters.size()> own{
      {{"georeference.enabled=false"},
       {"georeference.enabled=false", fmt::format("sensors.gps.offset_sigma_m={}", gps.correlated_m)},
       {"georeference.enabled=true"}}};
  std::vector<Scenario> scenarios;
  for (std::size_t filter = 0; filter < kFilters.size(); ++filter) {
    for (const int particles : kParticles) {
      std::vector<std::string> overrides = own[filter];
      overrides.push_back(fmt::format("filter.particles={}", particles));
      scenarios.push_back({static_cast<int>(scenarios.size()) + 1,
                           fmt::format("{}, {}", kFilters[filter].title, particles), overrides});
    }
  }
  return scenarios;
}

void Sawtooth::run(const std::string& file, std::size_t which, std::size_t seed) {
  std::vector<std::string> common = overrides;
  if (gps[which].rate_hz == 0.0) {
    common.emplace_back("sensors.gps.enabled=false");
  } else {
    common.push_back(fmt::format("source.gps.rate_hz={}", gps[which].rate_hz));
    common.push_back(fmt::format("source.gps.correlated_sigma_m={}", gps[which].correlated_m));
  }
  trials[which][seed] = paper::run(file, common, {seeds[seed], noise, {}}, scenarios(gps[which]));
}

std::string to_page(const Sawtooth& results) {
  std::string text = fmt::format(
      "# What a GPS does to SLAM\n\nMade by\n\n    {}\n\nfrom `{}`: {} seeds of noise in one world, odometry noise × "
      "{:g}, the same measurements for all filters.{}\nIn each cell: one particle, 25 particles. Down: rate of the "
      "GPS, 0.3 m of white noise. Across: σ of its slowly varying error (each axis, 60 s).\n",
      results.command, results.config, results.seeds.size(), results.noise,
      results.overrides.empty() ? std::string() : fmt::format(" Changed: `{}`.", fmt::join(results.overrides, "`, `")));
  for (std::size_t filter = 0; filter < kFilters.size(); ++filter) {
    text += fmt::format("\n## {}\n{}\n", kFilters[filter].title, kFilters[filter].text);
    text +=
        "\nMap right (every cylinder once within half the least distance between two, nothing else, no wrong "
        "association), share of seeds:\n\n" +
        table(results, filter, [](const auto& trials) { return share(trials, is_right_in_place); });
    text += "\nMap right in itself (every cylinder once, no wrong association, but anywhere):\n\n" +
            table(results, filter, [](const auto& trials) { return share(trials, is_consistent); });
    text += "\nPose, RMS [m], min / **median** / max over the seeds:\n\n" + table(results, filter, position_rms);
  }
  return text;
}

std::string to_json(const Sawtooth& results) {
  nlohmann::ordered_json json;
  json["command"] = results.command;
  json["trials"] = nlohmann::ordered_json::array();
  for (std::size_t g = 0; g < results.gps.size(); ++g) {
    for (std::size_t k = 0; k < results.seeds.size(); ++k) {
      for (std::size_t s = 0; s < results.trials[g][k].size(); ++s) {
        const Trial& t = results.trials[g][k][s];
        json["trials"].push_back({{"gps_rate_hz", results.gps[g].rate_hz},
                                  {"gps_correlated_m", results.gps[g].correlated_m},
                                  {"seed", results.seeds[k]},
                                  {"filter", s / kParticles.size() + 1},
                                  {"particles", kParticles[s % kParticles.size()]},
                                  {"right", is_right_in_place(t)},
                                  {"consistent", is_consistent(t)},
                                  {"landmarks", t.landmarks.counted},
                                  {"matched", t.landmarks.matched},
                                  {"wrong_associations", t.associations.wrong},
                                  {"position_rms_m", t.position_rms_m},
                                  {"yaw_rms_rad", t.yaw_rms_rad},
                                  {"position_end_m", t.position_end_m},
                                  {"nees_mean", t.nees_mean}});
      }
    }
  }
  return json.dump(1) + "\n";
}

}  // namespace waymark::paper
