// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/association_error.hpp"

#include <cstdint>
#include <map>

#include "apps/waymark/evaluation/trajectory_error.hpp"

namespace waymark::evaluation {
namespace {

constexpr int kNothing = -1;  // a detection of nothing that is surveyed

int thing_at(const Eigen::Vector2d& p_map, const std::vector<Landmark>& survey, double radius) {
  int nearest = kNothing;
  for (std::size_t i = 0; i < survey.size(); ++i) {
    const double distance = (survey[i].p_map - p_map).norm();
    if (distance > radius) continue;
    radius = distance;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

double AssociationError::precision() const { return share(correct, correct + wrong); }
double AssociationError::recall() const { return share(found, known); }

AssociationError score_associations(const std::vector<Sighting>& sightings, const Trajectory& truth,
                                    const std::vector<Landmark>& survey, double match_radius_m, int min_sightings) {
  std::map<std::int64_t, int> sightings_of;
  for (const Sighting& sighting : sightings) ++sightings_of[sighting.landmark];

  AssociationError score;
  std::map<std::int64_t, int> thing_of;     // landmark → thing
  std::map<int, std::int64_t> landmark_of;  // thing → its landmark
  for (const Sighting& sighting : sightings) {
    constexpr double kTruthGap = 1.0;  // [s]
    Pose T_map_base;
    if (pose_at(truth, sighting.stamp, kTruthGap, T_map_base) != Lookup::found) continue;
    const Eigen::Vector3d p_map = T_map_base * Eigen::Vector3d(sighting.p_base.x(), sighting.p_base.y(), 0.0);
    const int thing = thing_at(p_map.head<2>(), survey, match_radius_m);
    const auto own = landmark_of.find(thing);
    if (thing != kNothing && own != landmark_of.end()) {
      ++score.known;
      score.found += own->second == sighting.landmark ? 1 : 0;
    }
    if (sighting.is_first) {
      thing_of[sighting.landmark] = thing;
      if (own == landmark_of.end() && sightings_of[sighting.landmark] >= min_sightings)
        landmark_of[thing] = sighting.landmark;
      continue;
    }
    const auto meant = thing_of.find(sighting.landmark);
    const int other = meant == thing_of.end() ? kNothing : meant->second;
    if (thing == kNothing && other == kNothing) continue;  // a stone again, or another: unknown
    ++(thing == other ? score.correct : score.wrong);
  }
  return score;
}

}  // namespace waymark::evaluation
