// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/evaluate_options.hpp"
#include "apps/waymark/evaluation/overlay.hpp"
#include "apps/waymark/evaluation/report.hpp"
#include "apps/waymark/evaluation/run_comparison.hpp"
#include "apps/waymark/evaluation/run_results.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::command {
namespace {

std::optional<evaluation::Columns> columns_of(const std::string& text, const std::vector<std::string>& allowed) {
  if (text.empty()) return std::nullopt;
  return evaluation::parse_columns(text, allowed);
}

std::optional<Datum> datum_of(const EvaluateOptions& arguments) {
  const std::vector<double>& d = arguments.datum;
  if (d.empty()) return std::nullopt;
  const double height = d.size() > 2 ? d[2] : 0.0;
  if (!(std::abs(d[0]) <= 90.0) || !(std::abs(d[1]) <= 180.0) || !std::isfinite(height))
    throw UsageError("evaluate: --datum must be latitude and longitude [deg] and perhaps a height [m]");
  return Datum{d[0], d[1], height};
}

std::vector<evaluation::Outage> outages_of(const EvaluateOptions& arguments, const evaluation::Trajectory& reference) {
  std::vector<evaluation::Outage> outages;
  for (const std::string& text : arguments.outages) outages.push_back(evaluation::parse_outage(text));
  if (arguments.pauses_longer_than_s > 0.0) {
    const auto found =
        arguments.pauses_of.empty()
            ? evaluation::pauses(reference, arguments.pauses_longer_than_s)
            : evaluation::pauses(evaluation::read_trajectory(arguments.pauses_of, std::nullopt, datum_of(arguments)),
                                 arguments.pauses_longer_than_s);
    outages.insert(outages.end(), found.begin(), found.end());
  }
  return outages;
}

/// x, y [m] and perhaps yaw [deg] of the frame that the relations are of.
Pose sensor_of(const std::vector<double>& numbers) {
  if (numbers.empty()) return {};
  for (const double number : numbers) {
    if (!std::isfinite(number))
      throw UsageError("evaluate: --relations-sensor must be finite numbers x,y[,yaw] [m, deg]");
  }
  const double yaw_deg = numbers.size() > 2 ? numbers[2] : 0.0;
  return Pose::planar(numbers[0], numbers[1], yaw_deg * std::numbers::pi / 180.0);
}

evaluation::RelationScore relations_of(const EvaluateOptions& arguments, const evaluation::Trajectory& estimate,
                                       const evaluation::RelationOptions& options) {
  std::optional<evaluation::Trajectory> motion;
  if (!arguments.relations_motion.empty()) motion = evaluation::read_trajectory(arguments.relations_motion);
  return evaluation::score_relations(evaluation::read_relations(arguments.relations), estimate, motion, options);
}

/// Trajectory, consistency, outages.
void score_against_reference(const EvaluateOptions& arguments, const evaluation::Trajectory& estimate,
                             bool covariance_was_asked, evaluation::Report& report) {
  const auto& quantities = evaluation::trajectory_quantities();
  const evaluation::TrajectoryOptions& options = report.trajectory_options;
  const evaluation::Trajectory reference = evaluation::read_trajectory(
      arguments.reference, columns_of(arguments.reference_columns, quantities), datum_of(arguments));
  report.trajectory = evaluation::score_trajectory(estimate, reference, options);
  const bool is_of_another_point =
      reference.orientation == evaluation::Orientation::none && !options.lever_arm_m.isZero();
  std::vector<evaluation::PoseCovariance> covariances;
  if (!arguments.covariance.empty()) {
    covariances = evaluation::read_covariances(arguments.covariance);
    const evaluation::ConsistencyOptions how{report.trajectory->T_reference_estimate, options.max_time_gap_s,
                                             options.lever_arm_m, arguments.reference_sigma_m};
    evaluation::Trajectory of_base = reference;  // the covariance is that of the base
    if (!is_of_another_point)
      for (auto& point : of_base.points) point.pose.p -= point.pose.q * options.lever_arm_m;
    try {
      report.consistency = evaluation::score_consistency(covariances, estimate, of_base, how);
      report.spatial_consistency = evaluation::score_spatial_consistency(covariances, estimate, of_base, how);
    } catch (const Error&) {
      if (covariance_was_asked) throw;  // else it was only there
    }
    // The error at the end of an outage is that of the point, and its heading is not known.
    if (is_of_another_point) covariances.clear();
  }
  if (!arguments.outages.empty() || arguments.pauses_longer_than_s > 0.0) {
    report.outage_options = arguments.outage;
    report.outage_options.max_time_gap_s = options.max_time_gap_s;
    report.outage_options.lever_arm_m = options.lever_arm_m;
    report.outages = evaluation::score_outages(outages_of(arguments, reference), estimate, reference, covariances,
                                               report.trajectory->T_reference_estimate, report.outage_options);
  }
}

evaluation::Report evaluate(const EvaluateOptions& arguments, bool covariance_was_asked) {
  require_consistent(arguments);
  evaluation::Report report;
  report.trajectory_options = arguments.trajectory;
  report.landmark_options = arguments.landmark;
  auto& options = report.trajectory_options;
  options.align = arguments.align == "se2"   ? evaluation::Alignment::se2
                  : arguments.align == "se3" ? evaluation::Alignment::se3
                                             : evaluation::Alignment::none;
  if (!arguments.lever_arm_m.empty()) {
    options.lever_arm_m = Eigen::Vector3d::Map(arguments.lever_arm_m.data());
    if (!options.lever_arm_m.allFinite())
      throw UsageError("evaluate: --lever-arm must be three finite numbers x,y,z [m]");
  }
  if (arguments.rpe_delta_s > 0.0) options.rpe_delta_s = arguments.rpe_delta_s;

  if (!arguments.estimate.empty()) {
    const auto& quantities = evaluation::trajectory_quantities();
    const evaluation::Trajectory estimate =
        evaluation::read_trajectory(arguments.estimate, columns_of(arguments.columns, quantities));
    if (!arguments.relations.empty()) {
      report.relation_options.T_base_sensor = sensor_of(arguments.relations_sensor);
      report.relation_options.max_time_gap_s = options.max_time_gap_s;
      report.relations = relations_of(arguments, estimate, report.relation_options);
    }
    if (!arguments.reference.empty()) score_against_reference(arguments, estimate, covariance_was_asked, report);
  }
  if (!arguments.diagnostics.empty()) report.innovations = evaluation::read_innovations(arguments.diagnostics);
  if (!arguments.landmarks.empty()) {
    const Pose T_survey_map = report.trajectory ? report.trajectory->T_reference_estimate : Pose{};
    report.landmarks = evaluation::score_landmarks(
        evaluation::read_landmarks(arguments.landmarks),
        evaluation::read_landmarks(arguments.survey,
                                   columns_of(arguments.survey_columns, evaluation::survey_quantities())),
        T_survey_map, report.landmark_options);
  }
  if (!arguments.voxels.empty())
    report.voxels =
        evaluation::score_voxels(arguments.voxels, evaluation::read_surfaces(arguments.surfaces), arguments.voxel);
  return report;
}

/// The options with what a run left in its folder, where they do not name another file.
EvaluateOptions of_run(const EvaluateOptions& given, const std::string& folder) {
  const evaluation::RunResults found = evaluation::find_results(folder);
  EvaluateOptions options = given;
  const auto fill = [](std::string& option, const std::filesystem::path& file) {
    if (option.empty()) option = file.string();
  };
  fill(options.estimate, found.estimate);
  const bool has_own_reference = given.reference.empty();
  fill(options.reference, found.reference);
  if (!options.reference.empty()) fill(options.covariance, found.covariance);
  fill(options.diagnostics, found.diagnostics);
  if (given.landmarks.empty() && given.survey.empty()) {
    options.landmarks = found.landmarks.string();
    options.survey = found.survey.string();
  } else if (given.landmarks.empty()) {
    options.landmarks = (std::filesystem::path(folder) / "landmarks.csv").string();
  }
  if (options.datum.empty() && found.datum)
    options.datum = {found.datum->latitude_deg, found.datum->longitude_deg, found.datum->height_m};
  if (has_own_reference && options.lever_arm_m.empty() && found.lever_arm_m)
    options.lever_arm_m = {found.lever_arm_m->x(), found.lever_arm_m->y(), found.lever_arm_m->z()};
  if (options.reference.empty() && options.relations.empty() && options.survey.empty() && options.voxels.empty() &&
      options.diagnostics.empty())
    throw Error(folder + ": has no reference and no held_out.csv; --reference FILE names one");
  if (options.reference.empty() && options.relations.empty()) options.estimate.clear();
  return options;
}

/// What a run is scored with, in one line.
std::string heading(const std::string& folder, const EvaluateOptions& options) {
  std::string text = folder + ":";
  for (const std::string& file : {options.estimate, options.reference, options.landmarks, options.diagnostics}) {
    if (file.empty()) continue;
    const std::filesystem::path path(file);
    const bool is_in_folder = path.parent_path() == std::filesystem::path(folder);
    text += fmt::format("{}{}", text.ends_with(':') ? " " : ", ", is_in_folder ? path.filename().string() : file);
  }
  return text + "\n";
}

evaluation::OverlayPath overlay_path(const std::string& name, const std::string& file,
                                     const std::optional<evaluation::Columns>& columns,
                                     const std::optional<Datum>& datum, const Pose& T_reference_estimate) {
  evaluation::OverlayPath path{name, {}};
  for (const auto& point : evaluation::read_trajectory(file, columns, datum).points)
    path.points.emplace_back((T_reference_estimate * point.pose).p.head<2>());
  return path;
}

void evaluate_all(const EvaluateOptions& given) {
  std::vector<EvaluateOptions> jobs;
  for (const std::string& folder : given.runs) jobs.push_back(of_run(given, folder));
  if (given.runs.empty()) jobs.push_back(given);
  std::vector<evaluation::NamedReport> reports;
  std::vector<evaluation::OverlayPath> paths;
  const bool covariance_was_asked = given.runs.empty() || !given.covariance.empty();
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const std::string name = given.runs.empty() ? given.estimate : given.runs[i];
    reports.push_back({name, evaluate(jobs[i], covariance_was_asked)});
    if (given.overlay.empty() || jobs[i].estimate.empty()) continue;
    const auto& quantities = evaluation::trajectory_quantities();
    const auto& scored = reports.back().report.trajectory;
    if (paths.empty() && scored)
      paths.push_back(overlay_path("reference", jobs[i].reference, columns_of(jobs[i].reference_columns, quantities),
                                   datum_of(jobs[i]), {}));
    paths.push_back(overlay_path(name, jobs[i].estimate, columns_of(jobs[i].columns, quantities), {},
                                 scored ? scored->T_reference_estimate : Pose{}));
  }
  if (!given.overlay.empty()) write_file(given.overlay, evaluation::overlay_svg(paths), Belongs::to_nobody);
  if (given.json) {
    print_output("{}",
                 reports.size() == 1 ? evaluation::to_json(reports.front().report) : evaluation::to_json(reports));
  } else if (reports.size() == 1) {
    print_output("{}{}", given.runs.empty() ? "" : heading(given.runs.front(), jobs.front()),
                 evaluation::to_text(reports.front().report));
  } else {
    print_output("{}", evaluation::to_table(reports));
  }
}

}  // namespace

void add_evaluate_command(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command =
      app.add_subcommand("evaluate", "Score a run: trajectory against a reference, map against a survey; compare runs");
  command->footer(
      "Example:\n  waymark evaluate out/quickstart\n"
      "  waymark evaluate out/first out/second --align se2 --overlay both.svg\n"
      "  waymark evaluate out/run --outage 30:45 --outage 80:90\n"
      "  waymark evaluate --estimate mine.txt --reference out/quickstart/reference.txt --align se2");
  add_evaluate_options(command, *options);
  command->callback([options, &exit_code] {
    evaluate_all(*options);
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
