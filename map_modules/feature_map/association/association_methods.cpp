// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/association_methods.hpp"

#include <algorithm>
#include <vector>

namespace waymark::feature_map {

namespace {

using Pair = FeatureAssociation::Pair;

/// Ties by index, so that the order is total.
bool likelier(const Pair& a, const Pair& b) {
  if (a.log_likelihood != b.log_likelihood) return a.log_likelihood > b.log_likelihood;
  return a.detection != b.detection ? a.detection < b.detection : a.nearby < b.nearby;
}

void take(int detection, int nearby, FeatureAssociation& association) {
  NearbyLandmarks::Entry& landmark = association.nearby[static_cast<std::size_t>(nearby)];
  association.landmark_of[static_cast<std::size_t>(detection)] = landmark.ref;
  landmark.taken = true;
}

int& at(std::vector<int>& values, int index) { return values[static_cast<std::size_t>(index)]; }

/// Gives detections that may be the same landmark, directly or through others, one number: the smallest of them.
void find_components(FeatureAssociation& association) {
  AssignmentWorkspace& w = association.workspace;
  w.component.resize(association.landmark_of.size());
  for (std::size_t d = 0; d < w.component.size(); ++d) w.component[d] = static_cast<int>(d);
  w.first_seeker.assign(association.nearby.size(), -1);
  const auto root = [&](int d) {
    while (at(w.component, d) != d) d = at(w.component, d);
    return d;
  };
  for (const Pair& pair : association.pairs) {
    int& seeker = at(w.first_seeker, pair.nearby);
    if (seeker < 0) {
      seeker = pair.detection;
      continue;
    }
    const int a = root(seeker);
    const int b = root(pair.detection);
    at(w.component, std::max(a, b)) = std::min(a, b);
  }
  for (std::size_t d = 0; d < w.component.size(); ++d) w.component[d] = root(static_cast<int>(d));
}

void solve_component(int component, double log_p0, FeatureAssociation& association) {
  AssignmentWorkspace& w = association.workspace;
  w.rows.clear();
  w.columns.clear();
  w.column_of.assign(association.nearby.size(), -1);
  for (std::size_t d = 0; d < w.component.size(); ++d) {
    if (w.component[d] == component) w.rows.push_back(static_cast<int>(d));
  }
  for (const Pair& pair : association.pairs) {
    if (at(w.component, pair.detection) != component || at(w.column_of, pair.nearby) >= 0) continue;
    at(w.column_of, pair.nearby) = static_cast<int>(w.columns.size());
    w.columns.push_back(pair.nearby);
  }
  if (w.columns.empty()) return;

  // Every detection has a column of its own for "new", at no cost; a pair's cost is what it is better than that. A pair
  // that does not exist costs more than being new, so it is never taken.
  const auto rows = static_cast<Eigen::Index>(w.rows.size());
  const auto columns = static_cast<Eigen::Index>(w.columns.size());
  w.cost.assign(static_cast<std::size_t>(rows * (columns + rows)), 1.0);
  Eigen::Map<Eigen::MatrixXd> cost(w.cost.data(), rows, columns + rows);
  cost.rightCols(rows).diagonal().setZero();
  for (const Pair& pair : association.pairs) {
    if (at(w.component, pair.detection) != component) continue;
    const auto row = std::lower_bound(w.rows.begin(), w.rows.end(), pair.detection) - w.rows.begin();
    cost(row, at(w.column_of, pair.nearby)) = log_p0 - pair.log_likelihood;
  }
  const std::vector<int>& chosen = w.solver.solve(cost);
  for (std::size_t row = 0; row < w.rows.size(); ++row) {
    if (chosen[row] >= columns || cost(static_cast<Eigen::Index>(row), chosen[row]) > 0.0) continue;
    take(w.rows[row], at(w.columns, chosen[row]), association);
  }
}

}  // namespace

void associate_greedily(FeatureAssociation& association) {
  std::sort(association.pairs.begin(), association.pairs.end(), likelier);
  for (const Pair& pair : association.pairs) {
    const bool taken = association.nearby[static_cast<std::size_t>(pair.nearby)].taken;
    if (association.landmark_of[static_cast<std::size_t>(pair.detection)].chunk < 0 && !taken)
      take(pair.detection, pair.nearby, association);
  }
}

void associate_optimally(double log_p0, FeatureAssociation& association) {
  find_components(association);
  for (std::size_t d = 0; d < association.landmark_of.size(); ++d) {
    if (association.workspace.component[d] == static_cast<int>(d))
      solve_component(static_cast<int>(d), log_p0, association);
  }
}

}  // namespace waymark::feature_map
