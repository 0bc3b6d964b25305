// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/evaluate_options.hpp"

#include "apps/waymark/command/command_line.hpp"

namespace waymark::command {
namespace {

void add_outage_options(CLI::App* command, EvaluateOptions& a) {
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

void add_trajectory_options(CLI::App* command, EvaluateOptions& a) {
  command->add_option("--align", a.align, "alignment before scoring: none, se2 (plane, z ignored) or se3")
      ->check(CLI::IsMember({"none", "se2", "se3"}))
      ->capture_default_str();
  command
      ->add_option("--lever-arm", a.lever_arm_m,
                   "the reference is this point of the robot: x,y,z in the base frame [m]")
      ->delimiter(',')
      ->expected(3);
  command
      ->add_option("--reference-sigma", a.reference_sigma_m,
                   "σ of the reference's positions, each axis, which NEES takes into account [m]")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
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

void add_relation_options(CLI::App* command, EvaluateOptions& a) {
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

void add_map_options(CLI::App* command, EvaluateOptions& a) {
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

void require_consistent(const EvaluateOptions& arguments) {
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
        "evaluate: nothing to score; give the output folder of a run, --estimate with --reference, --landmarks with "
        "--survey, --estimate with --relations, --voxels with --surfaces, or --diagnostics");
  }
  if (arguments.reference.empty() && arguments.align != "none") {
    throw UsageError(
        "evaluate: --align needs --estimate and --reference (landmarks alone always get their own alignment as well)");
  }
}

void add_evaluate_options(CLI::App* command, EvaluateOptions& a) {
  command->add_option("runs", a.runs,
                      "output folders of runs: estimate, reference (or held_out.csv), landmarks, covariance, "
                      "diagnostics, datum and lever arm are found there; several are compared");
  command->add_option("--overlay", a.overlay, "write a picture of all trajectories (SVG)");
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
}

}  // namespace waymark::command
