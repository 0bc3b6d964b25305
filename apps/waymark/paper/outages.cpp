// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/paper/outages.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "apps/waymark/paper/course.hpp"
#include "apps/waymark/paper/spread.hpp"
#include "waymark/host/session.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::paper {
namespace {

using evaluation::OutageError;
using evaluation::Trajectory;

constexpr double kShortest = 2.0;  // [s] without a fix that count as an outage

/// Pose and covariance after every measurement, and when there were fixes.
class Recorder {
 public:
  void add(const Snapshot& snapshot) {
    if (snapshot.measurement().payload->type() == GnssFix::kType)
      fixes_.points.push_back({snapshot.measurement().stamp, Pose{}});
    if (!snapshot.started()) return;
    // Of equal stamps the last one has all updates.
    if (!estimate_.points.empty() && estimate_.points.back().stamp == snapshot.stamp()) {
      estimate_.points.pop_back();
      covariances_.pop_back();
    }
    estimate_.points.push_back({snapshot.stamp(), snapshot.belief().mean.T_map_base});
    covariances_.push_back({snapshot.stamp(), pose_covariance(snapshot.belief(), snapshot.layout())});
  }

  OutageTrial score(const Trajectory& truth) const {
    const evaluation::TrajectoryOptions options;
    const auto error = evaluation::score_trajectory(estimate_, truth, options);
    OutageTrial trial;
    trial.position_rms_m = error.position_m.rms;
    trial.yaw_rms_rad = error.yaw_rad ? error.yaw_rad->rms : 0.0;
    trial.nees_mean =
        evaluation::score_consistency(covariances_, estimate_, truth, {.max_time_gap_s = options.max_time_gap_s})
            .nees.mean;
    trial.outages =
        evaluation::score_outages(evaluation::pauses(fixes_, kShortest), estimate_, truth, covariances_, Pose{}, {});
    return trial;
  }

 private:
  Trajectory estimate_{"estimate", false, evaluation::Orientation::yaw, {}};
  Trajectory fixes_{"fixes", false, evaluation::Orientation::none, {}};
  std::vector<evaluation::PoseCovariance> covariances_;
};

/// One figure of outage number `which`, of the seeds that have it.
std::vector<double> of_outage(const Outages& results, std::size_t which, std::optional<double> OutageError::*member) {
  std::vector<double> values;
  for (const OutageTrial& trial : results.trials) {
    if (which < trial.outages.size() && trial.outages[which].*member) values.push_back(*(trial.outages[which].*member));
  }
  return values;
}

std::string table(const Outages& results) {
  std::string text =
      "| outage [s] | error at its end [m] | predicted σ [m] | error [σ] | first step after it [m] | step [σ] | steps "
      "within 3 σ |\n|---|---|---|---|---|---|---|\n";
  for (std::size_t k = 0; k < results.trials.front().outages.size(); ++k) {
    const evaluation::Outage& outage = results.trials.front().outages[k].outage;
    const auto cell = [&](std::optional<double> OutageError::*member) {
      return spread(of_outage(results, k, member), 2);
    };
    const std::vector<double> steps = of_outage(results, k, &OutageError::step_sigma);
    const auto small = std::ranges::count_if(steps, [](double step) { return step <= 3.0; });
    text += fmt::format("| {:.2f} to {:.2f} | {} | {} | {} | {} | {} | {} of {} |\n",
                        to_seconds(outage.begin.time_since_epoch()), to_seconds(outage.end.time_since_epoch()),
                        cell(&OutageError::position_end_m), cell(&OutageError::sigma_end_m),
                        cell(&OutageError::error_end_sigma), cell(&OutageError::step_m), cell(&OutageError::step_sigma),
                        small, steps.size());
  }
  return text;
}

}  // namespace

void Outages::run(std::size_t seed, const std::filesystem::path& pictures) {
  std::vector<std::string> own = overrides;
  own.push_back(fmt::format("source.seed={}", seeds[seed]));
  own.push_back(fmt::format("filter.seed={}", seeds[seed]));
  own.emplace_back("filter.threads=1");
  host::Robot robot = host::Robot::load(config, own);
  std::erase_if(robot.sinks, [&](const host::SinkSlot& slot) { return pictures.empty() || slot.plugin != "plot"; });
  const Trajectory truth = truth_of(*robot.source);
  Recorder recorder;
  host::SessionOptions options;
  options.out = pictures;
  options.owns_folder = false;
  options.observer = [&](const Snapshot& snapshot, double) { recorder.add(snapshot); };
  host::Session session(std::move(robot), std::move(options));
  session.play();
  refuse_failures(session.finish());
  trials[seed] = recorder.score(truth);
}

std::string to_page(const Outages& results, const std::string& pictures) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const auto whole = [&](const char* name, double factor, double OutageTrial::*member) {
    std::vector<double> values;
    values.reserve(results.trials.size());
    for (const OutageTrial& trial : results.trials) values.push_back(factor * trial.*member);
    return fmt::format("| {} | {} |\n", name, spread(values, 2));
  };
  return fmt::format(
             "# Short outages of the GPS\n\nFigs. 3.1 and 3.2 of the paper: the EKF alone, with wheels and GPS. Made by"
             "\n\n    {0}\n\nfrom `{1}`: {2} seed{3} of noise.{4} Cells are min / **median** / max over the seeds.\n\n"
             "![Fig. 3.1]({5}/fig_3_1.png)\n\n*Fig. 3.1: EKF (blue), GPS (green) and truth (red) in UTM; seed {6}.*\n\n"
             "![Fig. 3.2]({5}/fig_3_2.png)\n\n*Fig. 3.2: the sawtooth, a detail of it.*\n\n",
             results.command, results.config, results.seeds.size(), results.seeds.size() == 1 ? "" : "s",
             results.overrides.empty() ? std::string()
                                       : fmt::format(" Changed: `{}`.", fmt::join(results.overrides, "`, `")),
             pictures, results.seeds.front()) +
         table(results) +
         "\nAn outage lasts from the last fix before it to the first one after it. Error, and σ in the position's "
         "worst "
         "direction: at its end, before that fix; in σ: √(eᵀ P⁻¹ e). Step: the largest within two seconds of what a "
         "pose "
         "differs from those before it, moved on; in σ of the covariance before it.\n\n| over the whole drive | |\n"
         "|---|---|\n" +
         whole("position, RMS [m]", 1.0, &OutageTrial::position_rms_m) +
         whole("yaw, RMS [°]", kDegrees, &OutageTrial::yaw_rms_rad) +
         whole("NEES of (x, y, yaw), mean (3 is right)", 1.0, &OutageTrial::nees_mean);
}

std::string to_json(const Outages& results) {
  const auto number = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json json;
  json["command"] = results.command;
  json["trials"] = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < results.seeds.size(); ++k) {
    const OutageTrial& trial = results.trials[k];
    nlohmann::ordered_json one{{"seed", results.seeds[k]},
                               {"position_rms_m", trial.position_rms_m},
                               {"yaw_rms_rad", trial.yaw_rms_rad},
                               {"nees_mean", trial.nees_mean},
                               {"outages", nlohmann::ordered_json::array()}};
    for (const OutageError& outage : trial.outages) {
      one["outages"].push_back({{"begin_s", to_seconds(outage.outage.begin.time_since_epoch())},
                                {"end_s", to_seconds(outage.outage.end.time_since_epoch())},
                                {"position_end_m", number(outage.position_end_m)},
                                {"position_max_m", number(outage.position_max_m)},
                                {"sigma_end_m", number(outage.sigma_end_m)},
                                {"error_end_sigma", number(outage.error_end_sigma)},
                                {"step_m", number(outage.step_m)},
                                {"step_sigma", number(outage.step_sigma)}});
    }
    json["trials"].push_back(std::move(one));
  }
  return json.dump(1) + "\n";
}

}  // namespace waymark::paper
