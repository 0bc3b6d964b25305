// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>

namespace waymark::evaluation {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string_view name_of(Alignment align) {
  return align == Alignment::se2 ? "se2" : align == Alignment::se3 ? "se3" : "none";
}

void line(std::string& out, std::string_view label, const std::string& value) {
  out += fmt::format("  {:<26}{}\n", label, value);
}

std::string metres(const ErrorStatistics& e) {
  return fmt::format("rms {:.4f} m   mean {:.4f}   median {:.4f}   max {:.4f}", e.rms, e.mean, e.median, e.max);
}

std::string degrees(const ErrorStatistics& e) {
  return fmt::format("rms {:.4f} deg mean {:.4f}   median {:.4f}   max {:.4f}", e.rms * kDegrees, e.mean * kDegrees,
                     e.median * kDegrees, e.max * kDegrees);
}

std::string planar_text(const Pose& T) {
  return fmt::format("x {:.4f} m, y {:.4f} m, yaw {:.4f} deg", T.p.x(), T.p.y(), T.yaw() * kDegrees);
}

std::string alignment_text(const TrajectoryError& e) {
  if (e.align == Alignment::none) return "none";
  if (e.align == Alignment::se2) return "se2: " + planar_text(e.T_reference_estimate);
  const Eigen::Vector3d rpy = so3::to_rpy(e.T_reference_estimate.q) * kDegrees;
  const Eigen::Vector3d& p = e.T_reference_estimate.p;
  return fmt::format("se3: x {:.4f}, y {:.4f}, z {:.4f} m, roll {:.4f}, pitch {:.4f}, yaw {:.4f} deg", p.x(), p.y(),
                     p.z(), rpy.x(), rpy.y(), rpy.z());
}

void segments_text(const SegmentErrors& e, std::string& out) {
  if (e.all.segments == 0) return;
  line(out, "KITTI segments",
       fmt::format("{:.4f} % translation, {:.6f} deg/m rotation ({} segments)", 100.0 * e.all.translation,
                   kDegrees * e.all.rotation_rad_per_m, e.all.segments));
  std::string by_length;
  for (const SegmentErrors::Length& one : e.by_length)
    by_length += fmt::format("{}{:g} m {:.3f} %", by_length.empty() ? "" : ", ", one.length_m, 100.0 * one.translation);
  line(out, "", by_length);
}

void trajectory_text(const TrajectoryError& e, const TrajectoryOptions& options, std::string& out) {
  out += "trajectory\n";
  line(out, "scored",
       fmt::format("{} of {} reference points ({} outside the estimate, {} in gaps over {:g} s)", e.scored,
                   e.reference_points, e.outside, e.in_gap, options.max_time_gap_s));
  line(out, "span", fmt::format("{:.1f} s, {:.1f} m", e.duration_s, e.reference_length_m));
  line(out, "alignment", alignment_text(e));
  if (!options.lever_arm_m.isZero()) {
    const Eigen::Vector3d& l = options.lever_arm_m;
    line(out, "lever arm", fmt::format("{:g}, {:g}, {:g} m", l.x(), l.y(), l.z()));
  }
  if (e.is_planar) {
    line(out, "position error (plane)", metres(e.horizontal_m));
    line(out, "  with the height (3-D)", fmt::format("rms {:.4f} m; the estimate is planar", e.position_m.rms));
  } else {
    line(out, e.dimensions == 3 ? "position error (3-D)" : "position error (plane)", metres(e.position_m));
    if (e.dimensions == 3) line(out, "  its part in the plane", fmt::format("rms {:.4f} m", e.horizontal_m.rms));
  }
  if (e.yaw_rad) line(out, "yaw error", degrees(*e.yaw_rad));
  segments_text(e.segments, out);
  const double delta = options.rpe_delta_s.value_or(options.rpe_delta_m);
  const std::string_view unit = options.rpe_delta_s ? "s" : "m";
  const std::string label = fmt::format("relative error over {:g} {}", delta, unit);
  if (e.relative.pairs == 0) {
    line(out, label, fmt::format("none: no scored points between {:g} and {:g} {} apart", delta, 2.0 * delta, unit));
    return;
  }
  line(out, label, metres(e.relative.translation_m));
  if (e.relative.rotation_rad) line(out, "", degrees(*e.relative.rotation_rad));
  line(out, "",
       fmt::format("{} pairs, {:.3f} {} apart on average{}", e.relative.pairs, e.relative.mean_delta, unit,
                   e.relative.rotation_rad ? "" : ", compared in the map frame (no orientation)"));
}

void consistency_text(const Consistency& c, std::string& out) {
  line(out,
       c.dimensions == 6   ? "NEES of all six"
       : c.dimensions == 3 ? "NEES of x, y, yaw"
                           : "NEES of x, y",
       fmt::format(
           "mean {:.2f}   median {:.2f}   max {:.1f}   below the 95 % bound {:.1f} % ({} scored; right: mean {})",
           c.nees.mean, c.nees.median, c.nees.max, 100.0 * c.share_within_95, c.scored, c.dimensions));
  line(out, "  two-sided 95 %",
       fmt::format("{:.2f} to {:.2f}: {:.1f} % below, {:.1f} % above (right: 2.5 % each)", c.low_95, c.high_95,
                   100.0 * c.share_below, 100.0 * c.share_above));
}

std::string number_text(const std::optional<double>& value, double factor = 1.0) {
  return value ? fmt::format("{:.3f}", factor * *value) : std::string("-");
}

void outages_text(const std::vector<OutageError>& outages, const OutageOptions& options, std::string& out) {
  out += fmt::format("outages{}\n  {:>12} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10}\n",
                     outages.empty() ? ": none" : "", "end [s]", "for [s]", "error [m]", "yaw [deg]", "largest[m]",
                     "sigma [m]", "in sigma", "step [m]", "in sigma");
  for (const OutageError& one : outages) {
    out += fmt::format("  {:>12.3f} {:>8.2f} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10}\n",
                       to_seconds(one.outage.end.time_since_epoch()), to_seconds(one.outage.end - one.outage.begin),
                       number_text(one.position_end_m), number_text(one.yaw_end_rad, kDegrees),
                       number_text(one.position_max_m), number_text(one.sigma_end_m), number_text(one.error_end_sigma),
                       number_text(one.step_m), number_text(one.step_sigma));
  }
  out += fmt::format("  error, yaw, sigma: at the end, before anything new; step: the largest within {:g} s after it\n",
                     options.settling_s);
}

std::string spread_text(const Spread& one, std::string_view unit, double factor) {
  return fmt::format("mean {:.4f} +- {:.4f} {}   max {:.4f}", one.mean * factor, one.deviation * factor, unit,
                     one.max * factor);
}

void relation_errors_text(const RelationErrors& e, std::string& out) {
  line(out, "  translation", spread_text(e.translation_m, "m", 1.0));
  line(out, "    squared", spread_text(e.translation_squared_m2, "m^2", 1.0));
  line(out, "  rotation", spread_text(e.rotation_rad, "deg", kDegrees));
  line(out, "    squared", spread_text(e.rotation_squared_rad2, "deg^2", kDegrees * kDegrees));
}

void relations_text(const RelationScore& score, const RelationOptions& options, std::string& out) {
  out += "relations\n";
  line(out, "used",
       fmt::format("{} of {} ({} whose times the estimate does not cover)", score.all.count, score.relations,
                   score.uncovered));
  line(out, "poses",
       fmt::format("{} of {} are rows of the estimate, the others lie between", score.poses_at_row, score.poses));
  relation_errors_text(score.all, out);
  line(out, fmt::format("over {:g} s apart", options.far_apart_s), fmt::format("{} used", score.far_apart.count));
  if (score.far_apart.count > 0) relation_errors_text(score.far_apart, out);
}

std::string_view verdict(const InnovationScore& one) {
  return one.mean < one.low ? "below" : one.mean > one.high ? "above" : "inside";
}

void innovations_text(const std::vector<InnovationScore>& innovations, std::string& out) {
  out += "NIS, mean over a sensor's updates\n";
  for (const InnovationScore& one : innovations) {
    line(out, one.sensor,
         fmt::format("{:.3f}, expected {:.3f}, 95 % bounds {:.3f} to {:.3f} ({} updates): {}", one.mean, one.expected,
                     one.low, one.high, one.updates, verdict(one)));
  }
}

void landmarks_text(const LandmarkError& e, const LandmarkOptions& options, std::string& out) {
  out += "landmarks\n";
  line(out, "matched", fmt::format("{} of {} surveyed, within {:g} m", e.matched, e.surveyed, options.match_radius_m));
  line(out, "counted",
       fmt::format("{} ({} with fewer than {} sightings left out)", e.counted, e.too_few_sightings,
                   options.min_sightings));
  line(out, "duplicates, others", fmt::format("{}, {}", e.duplicates, e.others));
  if (e.position_m) line(out, "position error", metres(*e.position_m));
  if (e.own_alignment) {
    line(out, "with own alignment", metres(e.own_alignment->position_m));
    line(out, "", fmt::format("{} matched; {}", e.own_alignment->matched, planar_text(e.own_alignment->T_survey_map)));
  }
  if (e.radius_m) line(out, "radius error", fmt::format("{}   bias {:.4f}", metres(*e.radius_m), *e.radius_bias_m));
  if (e.consistency) {
    line(out, "NEES",
         fmt::format("mean {:.2f} (2 expected)   median {:.2f}   max {:.1f}   inside the 95 % ellipse: {:.0f} %",
                     e.consistency->nees.mean, e.consistency->nees.median, e.consistency->nees.max,
                     100.0 * e.consistency->share_within_95));
  }
  if (!e.missed.empty()) line(out, "missed", fmt::format("{}", fmt::join(e.missed, ", ")));
}

void voxels_text(const VoxelError& e, std::string& out) {
  out += "voxels\n";
  line(out, "precision",
       fmt::format("{:.2f} %: {} of {} occupied voxels within {:g} m of a true surface", 100.0 * e.precision(), e.right,
                   e.occupied, e.tolerance_m));
  line(out, "recall",
       fmt::format("{:.2f} %: {} of {} points of true surfaces that were seen ({} were not)", 100.0 * e.recall(),
                   e.found, e.found + e.missed, e.points - e.found - e.missed));
  line(out, "distance to a surface", metres(e.distance_m));
}

void put(Json& out, const std::string& name, const std::string& unit, const std::optional<ErrorStatistics>& e) {
  out[name + "_rms_" + unit] = e ? Json(e->rms) : Json(nullptr);
  out[name + "_mean_" + unit] = e ? Json(e->mean) : Json(nullptr);
  out[name + "_median_" + unit] = e ? Json(e->median) : Json(nullptr);
  out[name + "_max_" + unit] = e ? Json(e->max) : Json(nullptr);
}

Json pose_json(const Pose& T) {
  const Eigen::Vector3d rpy = so3::to_rpy(T.q);
  return {{"x_m", T.p.x()},      {"y_m", T.p.y()},       {"z_m", T.p.z()},
          {"roll_rad", rpy.x()}, {"pitch_rad", rpy.y()}, {"yaw_rad", rpy.z()}};
}

Json segments_json(const SegmentErrors& e) {
  const auto of = [](const SegmentErrors::Length& one) {
    return Json{{"length_m", one.length_m},
                {"segments", one.segments},
                {"translation_percent", 100.0 * one.translation},
                {"rotation_deg_per_m", kDegrees * one.rotation_rad_per_m}};
  };
  if (e.all.segments == 0) return nullptr;
  Json out = of(e.all);
  out["by_length"] = Json::array();
  for (const SegmentErrors::Length& one : e.by_length) out["by_length"].push_back(of(one));
  return out;
}

Json trajectory_json(const TrajectoryError& e, const TrajectoryOptions& options) {
  Json out;
  out["reference_points"] = e.reference_points;
  out["scored"] = e.scored;
  out["outside"] = e.outside;
  out["in_gap"] = e.in_gap;
  out["max_time_gap_s"] = options.max_time_gap_s;
  out["duration_s"] = e.duration_s;
  out["reference_length_m"] = e.reference_length_m;
  out["dimensions"] = e.dimensions;
  out["alignment"] = name_of(e.align);
  out["reference_T_estimate"] = pose_json(e.T_reference_estimate);
  out["lever_arm_m"] = {options.lever_arm_m.x(), options.lever_arm_m.y(), options.lever_arm_m.z()};
  put(out, "ate", "m", e.position_m);
  put(out, "ate_horizontal", "m", e.horizontal_m);
  out["is_planar"] = e.is_planar || e.dimensions == 2;
  put(out, "yaw", "rad", e.yaw_rad);
  out["rpe_delta_m"] = options.rpe_delta_s ? Json(nullptr) : Json(options.rpe_delta_m);
  out["rpe_delta_s"] = options.rpe_delta_s ? Json(*options.rpe_delta_s) : Json(nullptr);
  out["rpe_pairs"] = e.relative.pairs;
  const bool any = e.relative.pairs > 0;
  out[options.rpe_delta_s ? "rpe_mean_delta_s" : "rpe_mean_delta_m"] =
      any ? Json(e.relative.mean_delta) : Json(nullptr);
  put(out, "rpe_translation", "m", any ? std::optional(e.relative.translation_m) : std::nullopt);
  put(out, "rpe_rotation", "rad", any ? e.relative.rotation_rad : std::nullopt);
  out["segments"] = segments_json(e.segments);
  return out;
}

Json consistency_json(const Consistency& c) {
  Json out{{"nees_scored", c.scored},
           {"nees_dimensions", c.dimensions},
           {"nees_mean", c.nees.mean},
           {"nees_median", c.nees.median},
           {"nees_max", c.nees.max},
           {"nees_share_within_95", c.share_within_95},
           {"nees_low_95", c.low_95},
           {"nees_high_95", c.high_95},
           {"nees_share_below", c.share_below},
           {"nees_share_above", c.share_above},
           {"nees_mean_low_95_if_independent", c.mean_low_95},
           {"nees_mean_high_95_if_independent", c.mean_high_95}};
  for (std::size_t q = 0; q < c.mean_by_quarter.size(); ++q)
    out[fmt::format("nees_mean_quarter_{}", q + 1)] = c.mean_by_quarter[q];
  constexpr std::array kAxes{"x", "y", "yaw"};
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    if (c.sigma_by_rms[i]) out[fmt::format("sigma_by_rms_{}", kAxes[i])] = *c.sigma_by_rms[i];
  }
  return out;
}

Json outages_json(const std::vector<OutageError>& outages) {
  const auto number = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  Json out = Json::array();
  for (const OutageError& one : outages) {
    out.push_back({{"begin_s", to_seconds(one.outage.begin.time_since_epoch())},
                   {"end_s", to_seconds(one.outage.end.time_since_epoch())},
                   {"position_end_m", number(one.position_end_m)},
                   {"yaw_end_rad", number(one.yaw_end_rad)},
                   {"position_max_m", number(one.position_max_m)},
                   {"sigma_end_m", number(one.sigma_end_m)},
                   {"error_end_sigma", number(one.error_end_sigma)},
                   {"step_m", number(one.step_m)},
                   {"step_sigma", number(one.step_sigma)}});
  }
  return out;
}

Json relation_errors_json(const RelationErrors& e) {
  Json out{{"used", e.count}};
  const auto put_spread = [&](const std::string& name, const std::string& unit, const Spread& one) {
    out[name + "_mean_" + unit] = e.count > 0 ? Json(one.mean) : Json(nullptr);
    out[name + "_std_" + unit] = e.count > 0 ? Json(one.deviation) : Json(nullptr);
    out[name + "_max_" + unit] = e.count > 0 ? Json(one.max) : Json(nullptr);
  };
  put_spread("translation", "m", e.translation_m);
  put_spread("translation_squared", "m2", e.translation_squared_m2);
  put_spread("rotation", "rad", e.rotation_rad);
  put_spread("rotation_squared", "rad2", e.rotation_squared_rad2);
  return out;
}

Json relations_json(const RelationScore& score, const RelationOptions& options) {
  return {{"relations", score.relations},
          {"uncovered", score.uncovered},
          {"poses", score.poses},
          {"poses_at_row", score.poses_at_row},
          {"max_time_gap_s", options.max_time_gap_s},
          {"base_T_sensor", pose_json(options.T_base_sensor)},
          {"all", relation_errors_json(score.all)},
          {"far_apart_s", options.far_apart_s},
          {"far_apart", relation_errors_json(score.far_apart)}};
}

Json innovations_json(const std::vector<InnovationScore>& innovations) {
  Json out = Json::array();
  for (const InnovationScore& one : innovations) {
    out.push_back({{"sensor", one.sensor},
                   {"updates", one.updates},
                   {"nis_mean", one.mean},
                   {"nis_expected", one.expected},
                   {"nis_mean_low_95", one.low},
                   {"nis_mean_high_95", one.high}});
  }
  return out;
}

Json landmarks_json(const LandmarkError& e, const LandmarkOptions& options) {
  Json out;
  out["match_radius_m"] = options.match_radius_m;
  out["min_sightings"] = options.min_sightings;
  out["surveyed"] = e.surveyed;
  out["counted"] = e.counted;
  out["too_few_sightings"] = e.too_few_sightings;
  out["matched"] = e.matched;
  out["duplicates"] = e.duplicates;
  out["others"] = e.others;
  out["missed"] = e.missed;
  put(out, "landmark", "m", e.position_m);
  out["own_alignment_matched"] = e.own_alignment ? Json(e.own_alignment->matched) : Json(nullptr);
  out["landmark_rms_own_alignment_m"] = e.own_alignment ? Json(e.own_alignment->position_m.rms) : Json(nullptr);
  out["landmark_max_own_alignment_m"] = e.own_alignment ? Json(e.own_alignment->position_m.max) : Json(nullptr);
  out["survey_T_map_own_alignment"] = e.own_alignment ? pose_json(e.own_alignment->T_survey_map) : Json(nullptr);
  put(out, "radius", "m", e.radius_m);
  out["radius_bias_m"] = e.radius_bias_m ? Json(*e.radius_bias_m) : Json(nullptr);
  out["nees_mean"] = e.consistency ? Json(e.consistency->nees.mean) : Json(nullptr);
  out["nees_median"] = e.consistency ? Json(e.consistency->nees.median) : Json(nullptr);
  out["nees_max"] = e.consistency ? Json(e.consistency->nees.max) : Json(nullptr);
  out["nees_share_within_95"] = e.consistency ? Json(e.consistency->share_within_95) : Json(nullptr);
  return out;
}

}  // namespace

Json voxels_json(const VoxelError& e) {
  Json out;
  out["tolerance_m"] = e.tolerance_m;
  out["occupied"] = e.occupied;
  out["right"] = e.right;
  out["precision"] = e.precision();
  out["points"] = e.points;
  out["found"] = e.found;
  out["missed"] = e.missed;
  out["recall"] = e.found + e.missed > 0 ? Json(e.recall()) : Json(nullptr);
  put(out, "distance", "m", e.distance_m);
  return out;
}

std::string to_text(const Report& report) {
  std::string out;
  if (report.trajectory) trajectory_text(*report.trajectory, report.trajectory_options, out);
  if (report.consistency) consistency_text(*report.consistency, out);
  if (report.spatial_consistency) consistency_text(*report.spatial_consistency, out);
  if (report.outages) outages_text(*report.outages, report.outage_options, out);
  if (report.relations) relations_text(*report.relations, report.relation_options, out);
  if (report.innovations) innovations_text(*report.innovations, out);
  if (report.landmarks) landmarks_text(*report.landmarks, report.landmark_options, out);
  if (report.voxels) voxels_text(*report.voxels, out);
  return out;
}

std::string to_json(const Report& report) {
  Json out;
  out["trajectory"] =
      report.trajectory ? trajectory_json(*report.trajectory, report.trajectory_options) : Json(nullptr);
  out["consistency"] = report.consistency ? consistency_json(*report.consistency) : Json(nullptr);
  if (report.spatial_consistency) out["consistency_of_six"] = consistency_json(*report.spatial_consistency);
  out["outages"] = report.outages ? outages_json(*report.outages) : Json(nullptr);
  out["relations"] = report.relations ? relations_json(*report.relations, report.relation_options) : Json(nullptr);
  out["innovations"] = report.innovations ? innovations_json(*report.innovations) : Json(nullptr);
  out["landmarks"] = report.landmarks ? landmarks_json(*report.landmarks, report.landmark_options) : Json(nullptr);
  out["voxels"] = report.voxels ? voxels_json(*report.voxels) : Json(nullptr);
  return out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace waymark::evaluation
