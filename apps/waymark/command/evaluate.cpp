// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/evaluation/report.hpp"
#include "waymark/base/error.hpp"

namespace waymark::command {
namespace {

struct Arguments {
  std::string estimate;
  std::string reference;
  std::string covariance;
  std::string diagnostics;
  std::vector<std::string> outages;
  std::string pauses_of;
  double pauses_longer_than_s = 0.0;  // 0: not given
  std::string relations;
  std::string relations_motion;
  std::vector<double> relations_sensor;  // x, y [m] and perhaps yaw [deg]
  std::string landmarks;
  std::string survey;
  std::string voxels;
  std::string surfaces;
  std::string columns;
  std::string reference_columns;
  std::string survey_columns;
  std::string align = "none";
  std::vector<double> lever_arm_m;
  std::vector<double> datum;
  double rpe_delta_s = 0.0;  // 0: not given
  bool json = false;
  evaluation::TrajectoryOptions trajectory;
  evaluation::LandmarkOptions landmark;
  evaluation::OutageOptions outage;
  evaluation::VoxelOptions voxel;
};

std::optional<evaluation::Columns> columns_of(const std::string& text, const std::vector<std::string>& allowed) {
  if (text.empty()) return std::nullopt;
  return evaluation::parse_columns(text, allowed);
}

std::optional<Datum> datum_of(const Arguments& arguments) {
  const std::vector<double>& d = arguments.datum;
  if (d.empty()) return std::nullopt;
  const double height = d.size() > 2 ? d[2] : 0.0;
  if (!(std::abs(d[0]) <= 90.0) || !(std::abs(d[1]) <= 180.0) || !std::isfinite(height))
    throw UsageError("evaluate: --datum must be latitude and longitude [deg] and perhaps a height [m]");
  return Datum{d[0], d[1], height};
}

std::vector<evaluation::Outage> outages_of(const Arguments& arguments, const evaluation::Trajectory& reference) {
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

evaluation::RelationScore relations_of(const Arguments& arguments, const evaluation::Trajectory& estimate,
                                       const evaluation::RelationOptions& options) {
  std::optional<evaluation::Trajectory> motion;
  if (!arguments.relations_motion.empty()) motion = evaluation::read_trajectory(arguments.relations_motion);
  return evaluation::score_relations(evaluation::read_relations(arguments.relations), estimate, motion, options);
}

/// Refuses options that mean nothing without others.
void check(const Arguments& arguments) {
  if (arguments.relations.empty() && arguments.estimate.empty() != arguments.reference.empty()) {
    throw UsageError("evaluate: --estimate and --reference belong together");
  }
  if (!arguments.relations.empty() && arguments.estimate.empty())
    throw UsageError("evaluate: --relations needs --estimate");
  if (arguments.landmarks.empty() != arguments.survey.empty()) {
    throw UsageError("evaluate: --landmarks and --survey belong together");
  }
  if (arguments.voxels.empty() != arguments.surfaces.empty()) {
    throw UsageError("evaluate: --voxels and --surfaces belong together");
  }
  if (!arguments.covariance.empty() && arguments.reference.empty()) {
    throw UsageError("evaluate: --covariance needs --estimate and --reference");
  }
  const bool outages = !arguments.outages.empty() || arguments.pauses_longer_than_s > 0.0;
  if (outages && arguments.reference.empty())
    throw UsageError("evaluate: --outage and --outages-longer-than need --estimate and --reference");
  if (arguments.estimate.empty() && arguments.landmarks.empty() && arguments.voxels.empty() &&
      arguments.diagnostics.empty()) {
    throw UsageError(
        "evaluate: nothing to score; give --estimate with --reference, --landmarks with --survey, --estimate with "
        "--relations, --voxels with --surfaces, or --diagnostics");
  }
  if (arguments.reference.empty() && arguments.align != "none") {
    throw UsageError(
        "evaluate: --align needs --estimate and --reference (landmarks alone always get their own alignment as well)");
  }
}

/// Trajectory, consistency, outages.
void score_against_reference(const Arguments& arguments, const evaluation::Trajectory& estimate,
                             evaluation::Report& report) {
  const auto& quantities = evaluation::trajectory_quantities();
  const evaluation::TrajectoryOptions& options = report.trajectory_options;
  const evaluation::Trajectory reference = evaluation::read_trajectory(
      arguments.reference, columns_of(arguments.reference_columns, quantities), datum_of(arguments));
  report.trajectory = evaluation::score_trajectory(estimate, reference, options);
  std::vector<evaluation::PoseCovariance> covariances;
  if (!arguments.covariance.empty()) {
    if (reference.orientation == evaluation::Orientation::none && !options.lever_arm_m.isZero()) {
      throw Error("evaluate: --covariance is that of the base, not of the point at --lever-arm, whose positions " +
                  reference.name + " holds; leave out one of the two");
    }
    covariances = evaluation::read_covariances(arguments.covariance);
    evaluation::Trajectory of_base = reference;  // the covariance is that of the base
    for (auto& point : of_base.points) point.pose.p -= point.pose.q * options.lever_arm_m;
    report.consistency = evaluation::score_consistency(covariances, estimate, of_base,
                                                       report.trajectory->T_reference_estimate, options.max_time_gap_s);
  }
  if (!arguments.outages.empty() || arguments.pauses_longer_than_s > 0.0) {
    report.outage_options = arguments.outage;
    report.outage_options.max_time_gap_s = options.max_time_gap_s;
    report.outage_options.lever_arm_m = options.lever_arm_m;
    report.outages = evaluation::score_outages(outages_of(arguments, reference), estimate, reference, covariances,
                                               report.trajectory->T_reference_estimate, report.outage_options);
  }
}

evaluation::Report evaluate(const Arguments& arguments) {
  check(arguments);
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
    if (!arguments.reference.empty()) score_against_reference(arguments, estimate, report);
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

void add_outage_options(CLI::App* command, Arguments& a) {
  command
      ->add_option("--outage", a.outages,
                   "begin:end [s] of a span without the sensor that bounds the position error; repeatable")
      ->allow_extra_args(false);
  auto* pauses_longer =
      command
          ->add_option("--outages-longer-than", a.pauses_longer_than_s,
                       "outages are also the pauses of the reference, or of --outages-of, longer than this [s]")
          ->check(positive_number());
  command->add_option("--outages-of", a.pauses_of, "the recording whose pauses count: columns t, x, y")
      ->needs(pauses_longer);
  command->add_option("--settling", a.outage.settling_s, "after an outage, where the largest step is looked for [s]")
      ->check(positive_number())
      ->capture_default_str();
}

void add_trajectory_options(CLI::App* command, Arguments& a) {
  command->add_option("--align", a.align, "alignment before scoring: none, se2 (plane, z ignored) or se3")
      ->check(CLI::IsMember({"none", "se2", "se3"}))
      ->capture_default_str();
  command
      ->add_option("--lever-arm", a.lever_arm_m,
                   "the reference is this point of the robot: x,y,z in the base frame [m]")
      ->delimiter(',')
      ->expected(3);
  command
      ->add_option("--datum", a.datum,
                   "where the map's origin is, for a geodetic reference: latitude,longitude[,height] as in the YAML "
                   "[deg, m]")
      ->delimiter(',')
      ->expected(2, 3);
  command
      ->add_option("--max-time-gap", a.trajectory.max_time_gap_s,
                   "longest pause of the estimate to interpolate over [s]")
      ->check(positive_number())
      ->capture_default_str();
  auto* by_length =
      command->add_option("--rpe-delta-m", a.trajectory.rpe_delta_m, "relative errors over this length of the path [m]")
          ->check(positive_number())
          ->capture_default_str();
  command->add_option("--rpe-delta-s", a.rpe_delta_s, "relative errors over this time [s]")
      ->check(positive_number())
      ->excludes(by_length);
  command->add_option("--columns", a.columns, "columns of the estimate, from 0: t=0,x=1,y=2[,z=..][,yaw=..]");
  command->add_option("--reference-columns", a.reference_columns, "columns of the reference, from 0");
}

void add_relation_options(CLI::App* command, Arguments& a) {
  auto* relations =
      command->add_option("--relations", a.relations,
                          "true motions between two times: t1 t2 x y z roll pitch yaw [s, m, rad]; needs no "
                          "--reference");
  command
      ->add_option("--relations-motion", a.relations_motion,
                   "trajectory without corrections, for times between the rows of the estimate: path.txt of dead "
                   "reckoning")
      ->needs(relations);
  command
      ->add_option("--relations-sensor", a.relations_sensor,
                   "the relations are of this frame of the robot: x,y[,yaw] in the base frame [m, deg]")
      ->delimiter(',')
      ->expected(2, 3)
      ->needs(relations);
}

void add_map_options(CLI::App* command, Arguments& a) {
  command->add_option("--landmarks", a.landmarks, "landmarks.csv of the landmarks sink");
  command->add_option("--survey", a.survey, "surveyed landmarks: id,x_m,y_m[,radius_m]");
  command->add_option("--survey-columns", a.survey_columns, "columns of the survey, from 0: name=0,x=1,y=2[,radius=3]");
  command
      ->add_option("--match-radius-m", a.landmark.match_radius_m,
                   "a landmark belongs to a survey point within this [m]")
      ->check(positive_number())
      ->capture_default_str();
  command->add_option("--min-sightings", a.landmark.min_sightings, "landmarks seen less often do not count")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  auto* voxels =
      command->add_option("--voxels", a.voxels, "octree (.bt, .ot): its occupied voxels against true surfaces");
  command->add_option("--surfaces", a.surfaces, "true surfaces, as the simulator writes them (surfaces_file)");
  command
      ->add_option("--voxel-tolerance-m", a.voxel.tolerance_m,
                   "the middle of a voxel is on a surface within this [m]; without it: the side of a voxel")
      ->check(positive_number())
      ->needs(voxels);
}

}  // namespace

void add_evaluate_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* command = app.add_subcommand("evaluate", "score a trajectory against a reference, a map against a survey");
  command->footer(
      "Example:\n  waymark evaluate --estimate out/quickstart/trajectory.txt --reference out/quickstart/reference.txt "
      "--align se2\n"
      "  waymark evaluate --estimate out/run/trajectory.txt --reference out/run/reference.txt \\\n"
      "      --covariance out/run/covariance.csv --diagnostics out/run/diagnostics.json --outage 30:45 --outage 80:90");
  command->add_option("--estimate", a.estimate, "trajectory to score: TUM, or text with column names; .gz too");
  command->add_option("--reference", a.reference, "reference trajectory, or positions such as held_out.csv");
  command->add_option(
      "--covariance", a.covariance,
      "covariance.csv of the tum sink: adds the NEES of x, y, yaw (of x, y if the reference has no yaw)");
  command->add_option("--diagnostics", a.diagnostics, "diagnostics.json of that sink: adds the NIS of every sensor");
  add_outage_options(command, a);
  add_trajectory_options(command, a);
  add_relation_options(command, a);
  add_map_options(command, a);
  command->add_flag("--json", a.json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    const evaluation::Report report = evaluate(*arguments);
    const std::string text = arguments->json ? evaluation::to_json(report) : evaluation::to_text(report);
    print_output("{}", text);
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
