// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/paper/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "apps/waymark/paper/representative.hpp"
#include "apps/waymark/paper/spread.hpp"

namespace waymark::paper {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// The trials of one scenario at one noise level.
std::vector<Trial> of_scenario(const std::vector<std::vector<Trial>>& by_seed, std::size_t scenario) {
  std::vector<Trial> trials;
  trials.reserve(by_seed.size());
  for (const std::vector<Trial>& seed : by_seed) trials.push_back(seed[scenario]);
  return trials;
}

using Quantity = std::function<double(const Trial&)>;

std::vector<double> values_of(const std::vector<Trial>& trials, const Quantity& quantity) {
  std::vector<double> values;
  values.reserve(trials.size());
  for (const Trial& trial : trials) values.push_back(quantity(trial));
  return values;
}

using Condition = std::function<bool(const Trial&)>;

std::string count(const std::vector<Trial>& trials, const Condition& condition) {
  const auto good = std::count_if(trials.begin(), trials.end(), condition);
  return fmt::format("{} of {} ({:.0f} %)", good, trials.size(),
                     100.0 * static_cast<double>(good) / static_cast<double>(trials.size()));
}

bool is_exact(const Trial& trial) { return trial.has_exact_map(); }
bool is_free_of_errors(const Trial& trial) { return trial.associations.wrong == 0; }
bool is_right(const Trial& trial) { return is_exact(trial) && is_free_of_errors(trial); }

/// One row of the table of scenarios.
struct Row {
  std::string name;
  std::function<std::string(const std::vector<Trial>&)> cell;
};

std::vector<Row> rows() {
  const auto shares = [](const char* name, const Condition& condition) {
    return Row{name, [condition](const std::vector<Trial>& trials) { return count(trials, condition); }};
  };
  const auto spreads = [](const char* name, const Quantity& quantity, int digits) {
    return Row{name, [quantity, digits](const std::vector<Trial>& trials) {
                 return spread(values_of(trials, quantity), digits);
               }};
  };
  const auto number = [](std::size_t value) { return static_cast<double>(value); };
  return {
      shares("every cylinder once, nothing else, no wrong association", is_right),
      shares("every cylinder once, nothing else", is_exact),
      shares("no wrong association", is_free_of_errors),
      spreads(
          "landmarks", [=](const Trial& t) { return number(t.landmarks.counted); }, 0),
      spreads(
          "duplicates", [=](const Trial& t) { return number(t.landmarks.duplicates); }, 0),
      spreads(
          "where there is no cylinder", [=](const Trial& t) { return number(t.landmarks.others); }, 0),
      spreads(
          "cylinders missed", [=](const Trial& t) { return number(t.landmarks.missed.size()); }, 0),
      spreads(
          "wrong associations", [=](const Trial& t) { return number(t.associations.wrong); }, 0),
      spreads(
          "association precision [%]", [](const Trial& t) { return 100.0 * t.associations.precision(); }, 1),
      spreads(
          "association recall [%]", [](const Trial& t) { return 100.0 * t.associations.recall(); }, 1),
      spreads(
          "pose, RMS [m]", [](const Trial& t) { return t.position_rms_m; }, 3),
      spreads(
          "pose, RMS [°]", [](const Trial& t) { return t.yaw_rms_rad * kDegrees; }, 2),
      spreads(
          "path of the best particle, RMS [m]", [](const Trial& t) { return t.path_rms_m; }, 3),
      spreads(
          "pose at the end [m]", [](const Trial& t) { return t.position_end_m; }, 3),
      spreads(
          "landmarks that match, RMS [m]",
          [](const Trial& t) { return t.landmarks.position_m ? t.landmarks.position_m->rms : 0.0; }, 3),
      spreads(
          "their radius, RMS [m]",
          [](const Trial& t) { return t.landmarks.radius_m ? t.landmarks.radius_m->rms : 0.0; }, 4),
      spreads(
          "NEES of (x, y, yaw), mean (3 is right)", [](const Trial& t) { return t.nees_mean; }, 1),
      spreads(
          "largest 3 sigma of the position [m]", [](const Trial& t) { return 3.0 * t.widest_sigma_m; }, 2),
  };
}

/// The scenarios of one filter, as indices into those of the experiment.
struct Group {
  std::string filter;  ///< empty: there is only one
  std::vector<std::size_t> scenarios;
};

std::vector<Group> groups_of(const Experiment& experiment) {
  std::vector<Group> groups;
  for (std::size_t s = 0; s < experiment.scenarios.size(); ++s) {
    const std::string& filter = experiment.scenarios[s].filter;
    if (groups.empty() || groups.back().filter != filter) groups.push_back({filter, {}});
    groups.back().scenarios.push_back(s);
  }
  return groups;
}

std::string header(const Results& results, const Group& group) {
  std::string line = "| |";
  std::string rule = "|---|";
  for (const std::size_t s : group.scenarios) {
    const Scenario& scenario = results.experiment.scenarios[s];
    line += fmt::format(" {}: {} |", scenario.number, scenario.title);
    rule += "---|";
  }
  return fmt::format("{}\n{}\n", line, rule);
}

std::string world_text(const std::vector<evaluation::Landmark>& world) {
  std::string text =
      "| cylinder, texture | x [m] | y [m] | radius [m] | to its neighbour [m] |\n|---|---|---|---|---|\n";
  for (const evaluation::Landmark& one : world) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const evaluation::Landmark& other : world) {
      if (&other != &one) nearest = std::min(nearest, (other.p_map - one.p_map).norm());
    }
    text += fmt::format("| {} | {:.2f} | {:.2f} | {:.3f} | {:.2f} |\n", one.name, one.p_map.x(), one.p_map.y(),
                        one.radius_m, nearest);
  }
  return text;
}

std::string table(const Results& results, std::size_t noise, const Group& group) {
  std::string text = header(results, group);
  for (const Row& row : rows()) {
    text += fmt::format("| {} |", row.name);
    for (const std::size_t s : group.scenarios)
      text += fmt::format(" {} |", row.cell(of_scenario(results.trials[noise], s)));
    text += "\n";
  }
  return text;
}

std::string sweep(const Results& results, const Group& group) {
  std::string text = header(results, group);
  for (std::size_t n = 0; n < results.noises.size(); ++n) {
    text += fmt::format("| × {:g} |", results.noises[n]);
    for (const std::size_t s : group.scenarios) {
      const std::vector<Trial> trials = of_scenario(results.trials[n], s);
      text += fmt::format(" {}; {} m |", count(trials, is_right), spread(values_of(trials, &Trial::position_rms_m), 2));
    }
    text += "\n";
  }
  return text;
}

/// What the filters make of the same measurements: a scenario a row, a filter a column.
std::string side_by_side(const Results& results, std::size_t noise, const std::vector<Group>& groups) {
  std::string text = "| every cylinder once, nothing else; landmarks; pose, RMS [m] |";
  std::string rule = "|---|";
  for (const Group& group : groups) {
    text += fmt::format(" {} |", group.filter);
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (std::size_t i = 0; i < groups.front().scenarios.size(); ++i) {
    const Scenario& scenario = results.experiment.scenarios[groups.front().scenarios[i]];
    text += fmt::format("| {}: {} |", scenario.number, scenario.title);
    for (const Group& group : groups) {
      const std::vector<Trial> trials = of_scenario(results.trials[noise], group.scenarios[i]);
      text += fmt::format(
          " {}; {}; {} |", count(trials, is_exact),
          spread(values_of(trials, [](const Trial& t) { return static_cast<double>(t.landmarks.counted); }), 0),
          spread(values_of(trials, &Trial::position_rms_m), 3));
    }
    text += "\n";
  }
  return text;
}

std::string figures(const Results& results, const std::string& pictures) {
  std::string text = fmt::format(
      "## Figures\nSeed {}. Blue arrow: weighted mean of the pose. Numbered: landmarks of the particle with the "
      "highest weight, with 3-sigma ellipses. Red: the truth. Orange dots: particles.\n\n",
      results.seeds.front());
  for (const Scenario& scenario : results.experiment.scenarios) {
    const std::string filter = scenario.filter.empty() ? "" : scenario.filter + ", ";
    text += fmt::format("![Scenario {0}]({1}/{2})\n\n*{3}scenario {0}: {4}.*\n\n", scenario.number, pictures,
                        scenario.picture, filter, scenario.title);
  }
  for (const Representative& one : representative_failures(results)) {
    text += fmt::format(
        "![Beside Fig. {0}]({1}/{2})\n\n*Beside Fig. {0} of the paper: scenario {3}, seed {4}: {5}. "
        "Chosen: {6}.*\n\n",
        one.figure, pictures, one.picture, results.experiment.scenarios[one.scenario].number, results.seeds[one.seed],
        one.failure, one.criterion);
  }
  return text;
}

}  // namespace

std::size_t shown_noise(const Results& results) {
  const auto base = std::find(results.noises.begin(), results.noises.end(), 1.0);
  return base == results.noises.end() ? 0 : static_cast<std::size_t>(base - results.noises.begin());
}

std::string to_page(const Results& results, const std::string& pictures) {
  const std::size_t shown = shown_noise(results);
  std::string text = fmt::format(
      "# {}\n\n{} Made by\n\n    {}\n\nfrom `{}`: {} seeds of noise and light in one world, the same measurements for "
      "all "
      "scenarios. Cells are min / **median** / max over the seeds.{}\n\n",
      results.experiment.heading, results.experiment.text, results.command, results.config, results.seeds.size(),
      results.overrides.empty() ? std::string() : fmt::format(" Changed: `{}`.", fmt::join(results.overrides, "`, `")));
  text += figures(results, pictures);
  const std::vector<Group> groups = groups_of(results.experiment);
  if (groups.size() > 1) {
    text += fmt::format("## Side by side\nThe same measurements, odometry noise × {:g}.\n\n{}\n", results.noises[shown],
                        side_by_side(results, shown, groups));
  }
  for (const Group& group : groups) {
    text +=
        fmt::format("## Scenarios{}\nOdometry noise × {:g}.\n\n{}\n", group.filter.empty() ? "" : ": " + group.filter,
                    results.noises[shown], table(results, shown, group));
  }
  text +=
      "A landmark counts once it was seen three times; it matches a cylinder within half the least distance between "
      "two cylinders. A detection shows the "
      "cylinder that stands where the true pose puts it; a landmark stands for what its first detection showed. "
      "Precision: detections that went into a landmark of the same cylinder, of all that went into one. Recall: "
      "detections that went into their cylinder's own landmark, not into a duplicate or a new one. All of the particle "
      "that has the highest weight at the end, and of its ancestors.\n";
  text += "\n## Odometry noise\nEvery cylinder once, nothing else, no wrong association; RMS of the pose.\n";
  for (const Group& group : groups)
    text += (group.filter.empty() ? "\n" : "\n" + group.filter + ":\n\n") + sweep(results, group);
  text += fmt::format("\n## World\n{}", world_text(results.world));
  return text;
}

std::string to_json(const Results& results) {
  nlohmann::ordered_json json;
  json["command"] = results.command;
  json["trials"] = nlohmann::ordered_json::array();
  for (std::size_t n = 0; n < results.noises.size(); ++n) {
    for (std::size_t k = 0; k < results.seeds.size(); ++k) {
      for (std::size_t s = 0; s < results.experiment.scenarios.size(); ++s) {
        const Trial& t = results.trials[n][k][s];
        nlohmann::ordered_json one;
        one["noise"] = results.noises[n];
        one["seed"] = results.seeds[k];
        one["scenario"] = results.experiment.scenarios[s].number;
        one["filter"] = results.experiment.scenarios[s].filter;
        one["exact_map"] = t.has_exact_map();
        one["landmarks"] = t.landmarks.counted;
        one["matched"] = t.landmarks.matched;
        one["duplicates"] = t.landmarks.duplicates;
        one["others"] = t.landmarks.others;
        one["missed"] = t.landmarks.missed;
        one["wrong_associations"] = t.associations.wrong;
        one["precision"] = t.associations.precision();
        one["recall"] = t.associations.recall();
        one["position_rms_m"] = t.position_rms_m;
        one["yaw_rms_deg"] = t.yaw_rms_rad * kDegrees;
        one["path_rms_m"] = t.path_rms_m;
        one["position_end_m"] = t.position_end_m;
        one["landmark_rms_m"] = t.landmarks.position_m ? t.landmarks.position_m->rms : 0.0;
        one["nees_mean"] = t.nees_mean;
        one["widest_sigma_m"] = t.widest_sigma_m;
        json["trials"].push_back(std::move(one));
      }
    }
  }
  return json.dump(1) + "\n";
}

}  // namespace waymark::paper
