// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/landmark_error.hpp"

#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "apps/waymark/evaluation/alignment.hpp"
#include "apps/waymark/evaluation/assignment.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

// A cycle of matchings is conceivable; a map that has not converged by then is reported as it stands.
constexpr int kMaxRounds = 50;

using Points = std::vector<Eigen::Vector2d>;

Points moved(const Points& points, const Pose& T) {
  Points out;
  for (const Eigen::Vector2d& p : points) out.emplace_back((T * Eigen::Vector3d(p.x(), p.y(), 0.0)).head<2>());
  return out;
}

std::vector<int> match(const Points& survey, const Points& map, double radius) {
  Eigen::MatrixXd cost(static_cast<Eigen::Index>(survey.size()), static_cast<Eigen::Index>(map.size()));
  for (std::size_t i = 0; i < survey.size(); ++i) {
    for (std::size_t j = 0; j < map.size(); ++j) {
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = (survey[i] - map[j]).squaredNorm();
    }
  }
  return assign(cost, radius * radius);
}

std::vector<double> distances(const Points& survey, const Points& map, const std::vector<int>& matches) {
  std::vector<double> out;
  for (std::size_t i = 0; i < survey.size(); ++i) {
    if (matches[i] >= 0) out.push_back((survey[i] - map[static_cast<std::size_t>(matches[i])]).norm());
  }
  return out;
}

std::optional<LandmarkError::OwnAlignment> own_alignment(const Points& survey, const Points& map, const Pose& start,
                                                         std::vector<int> matches, double radius) {
  LandmarkError::OwnAlignment out;
  out.T_survey_map = start;
  for (int round = 0; round < kMaxRounds; ++round) {
    Points from;
    Points to;
    for (std::size_t i = 0; i < survey.size(); ++i) {
      if (matches[i] < 0) continue;
      from.push_back(map[static_cast<std::size_t>(matches[i])]);
      to.push_back(survey[i]);
    }
    if (from.size() < 2) return std::nullopt;
    try {
      out.T_survey_map = fit_se2(from, to);
    } catch (const Error&) {
      return std::nullopt;  // the matched landmarks are all in one place
    }
    std::vector<int> again = match(survey, moved(map, out.T_survey_map), radius);
    const bool converged = again == matches;
    matches = std::move(again);
    if (converged) break;
  }
  std::vector<double> errors = distances(survey, moved(map, out.T_survey_map), matches);
  out.matched = errors.size();
  out.position_m = statistics(std::move(errors));
  return out;
}

}  // namespace

LandmarkError score_landmarks(const std::vector<Landmark>& landmarks, const std::vector<Landmark>& survey,
                              const Pose& T_survey_map, const LandmarkOptions& options) {
  LandmarkError out;
  out.surveyed = survey.size();
  Points file_map;
  std::vector<double> radii;
  std::vector<std::optional<Eigen::Matrix2d>> covariances;
  for (const Landmark& landmark : landmarks) {
    if (landmark.sightings < options.min_sightings) {
      ++out.too_few_sightings;
      continue;
    }
    file_map.push_back(landmark.p_map);
    radii.push_back(landmark.radius_m);
    covariances.push_back(landmark.P);
  }
  out.counted = file_map.size();
  Points surveyed;
  for (const Landmark& landmark : survey) surveyed.push_back(landmark.p_map);

  const Points map = moved(file_map, T_survey_map);
  const std::vector<int> matches = match(surveyed, map, options.match_radius_m);
  std::vector<bool> used(map.size(), false);
  std::vector<double> radius_errors;
  double radius_sum = 0.0;
  std::vector<double> nees;
  const Eigen::Matrix2d R = T_survey_map.q.toRotationMatrix().topLeftCorner<2, 2>();
  for (std::size_t i = 0; i < survey.size(); ++i) {
    if (matches[i] < 0) {
      out.missed.push_back(survey[i].name);
      continue;
    }
    const auto j = static_cast<std::size_t>(matches[i]);
    used[j] = true;
    ++out.matched;
    if (covariances[j]) {
      const Eigen::Vector2d error = R.transpose() * (map[j] - surveyed[i]);
      nees.push_back(error.dot(covariances[j]->inverse() * error));
    }
    const double radius_error = radii[j] - survey[i].radius_m;
    if (std::isfinite(radius_error)) {
      radius_errors.push_back(radius_error);
      radius_sum += radius_error;
    }
  }
  for (std::size_t j = 0; j < map.size(); ++j) {
    if (used[j]) continue;
    bool near = false;
    for (const Eigen::Vector2d& p : surveyed) near = near || (p - map[j]).norm() <= options.match_radius_m;
    ++(near ? out.duplicates : out.others);
  }
  if (out.matched > 0) out.position_m = statistics(distances(surveyed, map, matches));
  if (!nees.empty()) out.consistency = summarize_nees(std::move(nees), 2);
  if (!radius_errors.empty()) {
    out.radius_bias_m = radius_sum / static_cast<double>(radius_errors.size());
    out.radius_m = statistics(std::move(radius_errors));
  }
  out.own_alignment = own_alignment(surveyed, file_map, T_survey_map, matches, options.match_radius_m);
  return out;
}

}  // namespace waymark::evaluation
