// SPDX-License-Identifier: Apache-2.0
#include "association_methods.hpp"

#include <algorithm>
#include <cmath>

namespace waymark {

namespace {

using Pair = FeatureAssociation::Pair;

/// Ties by index, so that the order is total.
bool likelier(const Pair& a, const Pair& b) {
  if (a.log_likelihood != b.log_likelihood) return a.log_likelihood > b.log_likelihood;
  return a.detection != b.detection ? a.detection < b.detection : a.nearby < b.nearby;
}

void take(int detection, int nearby, FeatureAssociation& association) {
  NearbyLandmarks::Entry& landmark = association.nearby[static_cast<std::size_t>(nearby)];
  association.match[static_cast<std::size_t>(detection)] = landmark.ref;
  landmark.taken = true;
}

int& at(std::vector<int>& values, int index) { return values[static_cast<std::size_t>(index)]; }

/// Gives detections that may be the same landmark, directly or through others, one number: the smallest of them.
void find_components(FeatureAssociation& association) {
  AssociationWorkspace& w = association.workspace;
  w.component.resize(association.match.size());
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
  AssociationWorkspace& w = association.workspace;
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

/// The search of joint compatibility: detections in turn, each with one of its candidates or none.
template <int D>
class JointSearch {
 public:
  using Vector = Eigen::Matrix<double, D, 1>;
  using Matrix = Eigen::Matrix<double, D, D>;

  JointSearch(const FeatureMapSettings& settings, double log_p0, FeatureAssociation& association)
      : settings_(settings),
        w_(association.workspace),
        association_(association),
        log_pd_(std::log(settings.association.detection_probability)),
        log_p0_(log_p0) {}

  void run(const Eigen::Matrix3d& P) {
    w_.chosen.assign(association_.match.size(), -1);
    w_.best.assign(association_.match.size(), -1);
    search({Eigen::Vector3d::Zero(), P, 0.0, 0.0, 0}, 0);
  }

 private:
  /// Pose as the pairs so far refine it, and what they amount to.
  struct Partial {
    Eigen::Vector3d offset;
    Eigen::Matrix3d P;
    double squared_distance;
    double log_likelihood;
    int pairs;
  };

  void search(const Partial& partial, std::size_t detection) {
    if (++nodes_ > settings_.association.joint_max_nodes) return;
    const std::size_t count = association_.match.size();
    if (partial.pairs + static_cast<int>(count - detection) < best_pairs_) return;
    if (detection == count) {
      if (partial.pairs == best_pairs_ && partial.log_likelihood <= best_log_likelihood_) return;
      best_pairs_ = partial.pairs;
      best_log_likelihood_ = partial.log_likelihood;
      w_.best = w_.chosen;
      return;
    }
    for (std::size_t c = w_.begin_of[detection]; c < w_.begin_of[detection + 1]; ++c) {
      const AssociationWorkspace::JointCandidate& candidate = w_.candidates[c];
      bool& taken = association_.nearby[static_cast<std::size_t>(candidate.nearby)].taken;
      Partial next = partial;
      if (taken || !add(candidate, next)) continue;
      taken = true;
      w_.chosen[detection] = candidate.nearby;
      search(next, detection + 1);
      w_.chosen[detection] = -1;
      taken = false;
    }
    Partial without = partial;
    without.log_likelihood += log_p0_;
    search(without, detection + 1);
  }

  /// False if the set is not compatible with the candidate.
  bool add(const AssociationWorkspace::JointCandidate& candidate, Partial& set) const {
    const auto H = candidate.H.template topRows<D>();
    const Vector nu = candidate.nu.template head<D>() - H * set.offset;
    const Matrix S = H * set.P * H.transpose() + candidate.C.template topLeftCorner<D, D>();
    const Matrix S_inverse = S.inverse();
    const double squared_distance = nu.dot(S_inverse * nu);
    ++set.pairs;
    set.squared_distance += squared_distance;
    const auto& gates = settings_.association.joint_gates;
    if (static_cast<std::size_t>(set.pairs) > gates.size()) return false;
    if (set.squared_distance > gates[static_cast<std::size_t>(set.pairs - 1)]) return false;
    set.log_likelihood += log_pd_ + log_normal<D>(squared_distance, S.determinant()) + candidate.log_signature;
    const Eigen::Matrix<double, 3, D> K = set.P * H.transpose() * S_inverse;
    set.offset += K * nu;
    set.P -= K * S * K.transpose();
    return true;
  }

  const FeatureMapSettings& settings_;
  AssociationWorkspace& w_;
  FeatureAssociation& association_;
  double log_pd_;
  double log_p0_;
  int nodes_ = 0;
  int best_pairs_ = -1;
  double best_log_likelihood_ = 0.0;
};

}  // namespace

void match_greedily(FeatureAssociation& association) {
  std::sort(association.pairs.begin(), association.pairs.end(), likelier);
  for (const Pair& pair : association.pairs) {
    const bool taken = association.nearby[static_cast<std::size_t>(pair.nearby)].taken;
    if (association.match[static_cast<std::size_t>(pair.detection)].chunk < 0 && !taken)
      take(pair.detection, pair.nearby, association);
  }
}

void match_optimally(double log_p0, FeatureAssociation& association) {
  find_components(association);
  for (std::size_t d = 0; d < association.match.size(); ++d) {
    if (association.workspace.component[d] == static_cast<int>(d))
      solve_component(static_cast<int>(d), log_p0, association);
  }
}

template <int D>
void match_jointly(const FeatureMapSettings& settings, double log_p0, const Eigen::Vector3d& pose,
                   const Eigen::Matrix3d& P, const FeatureObservation& observation, FeatureAssociation& association) {
  AssociationWorkspace& w = association.workspace;
  // Candidates by detection, the likeliest first: the first leaf of the search is then near the greedy answer.
  std::sort(association.pairs.begin(), association.pairs.end(), [](const Pair& a, const Pair& b) {
    return a.detection != b.detection ? a.detection < b.detection : likelier(a, b);
  });
  w.candidates.clear();
  w.begin_of.assign(1, 0);
  std::size_t next = 0;
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    const DetectionModel<D> model(observation.detections[d], pose);
    for (; next < association.pairs.size() && association.pairs[next].detection == static_cast<int>(d); ++next) {
      const StoredLandmark landmark =
          association.nearby[static_cast<std::size_t>(association.pairs[next].nearby)].landmark;
      AssociationWorkspace::JointCandidate& candidate = w.candidates.emplace_back();
      candidate.nearby = association.pairs[next].nearby;
      candidate.log_signature = association.pairs[next].log_signature;
      candidate.nu.template head<D>() = model.z - landmark.mean().template head<D>();
      candidate.H.template topRows<D>() = model.jacobian(landmark.mean().template head<2>());
      candidate.C.template topLeftCorner<D, D>() = landmark.covariance().template topLeftCorner<D, D>() + model.R;
    }
    w.begin_of.push_back(w.candidates.size());
  }
  JointSearch<D>(settings, log_p0, association).run(P);
  for (std::size_t d = 0; d < w.best.size(); ++d) {
    if (w.best[d] >= 0) take(static_cast<int>(d), w.best[d], association);
  }
}

template void match_jointly<2>(const FeatureMapSettings&, double, const Eigen::Vector3d&, const Eigen::Matrix3d&,
                               const FeatureObservation&, FeatureAssociation&);
template void match_jointly<3>(const FeatureMapSettings&, double, const Eigen::Vector3d&, const Eigen::Matrix3d&,
                               const FeatureObservation&, FeatureAssociation&);

}  // namespace waymark
