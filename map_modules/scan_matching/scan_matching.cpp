// SPDX-License-Identifier: Apache-2.0
#include "scan_matching.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::grid {

namespace {

// Steps below these end a stage: the wide one need only lead into the narrow one's basin.
const Eigen::Vector3d kWideStep(3e-3, 3e-3, 1e-3);
const Eigen::Vector3d kNarrowStep(2e-4, 2e-4, 1e-4);
constexpr double kSpreadSigmas = 4.0;  // no draw is farther away than this, but for one in 3000

bool is_small(const Eigen::Vector3d& step, const Eigen::Vector3d& bound) {
  return (step.array().abs() < bound.array()).all();
}

/// (Λ⁻¹ + F)⁻¹ with F = diag(floor²), for a Λ that may be singular: no direction becomes better known than the floor,
/// and one that is not known stays unknown.
Eigen::Matrix3d with_floor(const Eigen::Matrix3d& information, const Eigen::Vector3d& floor) {
  const Eigen::Matrix3d white = floor.asDiagonal() * information * floor.asDiagonal();
  const gaussian::Eigen3 eigen = gaussian::eigen(white);
  const Eigen::Vector3d kept = eigen.values.array() / (1.0 + eigen.values.array());
  const Eigen::Vector3d back = floor.cwiseInverse();
  const Eigen::Matrix3d bounded = eigen.vectors * kept.asDiagonal() * eigen.vectors.transpose();
  const Eigen::Matrix3d result = back.asDiagonal() * bounded * back.asDiagonal();
  return 0.5 * (result + result.transpose());
}

/// How far a scan constrains the direction in which it says least, 0 … 1, and that direction (x, y).
///
/// A wall is rough, since its cells were hit by chance: so along a corridor, too, every match has a best place and a
/// curvature about it, a fourth of that across, and they mean nothing. But they end within a cell. Moved along by the
/// width of the wide field, the scan fits that as well as before, if nothing is there; beside an end wall or a door it
/// does not. Of both sides the better one counts: beyond the map's end nothing fits, which is no reason to stay.
struct Weakest {
  double share = 1.0;
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
};

Weakest weakest(const MatchTarget& target, const LikelihoodTable& wide, const Eigen::Vector3d& at,
                const Eigen::Matrix3d& information, double shift) {
  constexpr double kWeak = 0.5;    // of the strongest direction's information: above, nothing is in doubt
  constexpr double kRough = 0.01;  // of the likelihood: what roughness makes of it, at most
  Weakest result;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> planar(information.topLeftCorner<2, 2>());
  if (planar.eigenvalues().x() > kWeak * planar.eigenvalues().y()) return result;
  result.direction = planar.eigenvectors().col(0);
  const Eigen::Vector3d step(shift * result.direction.x(), shift * result.direction.y(), 0.0);
  const double best = target.fit(wide, at).score;
  const double fall = best - std::max(target.fit(wide, at + step).score, target.fit(wide, at - step).score);
  result.share = std::clamp(fall / (kRough * best) - 1.0, 0.0, 1.0);
  return result;
}

}  // namespace

ScanMatcher::ScanMatcher(const MatchSettings& settings, double resolution)
    : settings_(settings),
      resolution_(resolution),
      wide_(settings.wide_sigma, resolution),
      narrow_(settings.narrow_sigma, resolution) {}

double ScanMatcher::margin(const MatchPrior& prior) const {
  const double spread = is_wide(prior) ? kSpreadSigmas * std::sqrt(std::max(prior.P(0, 0), prior.P(1, 1))) : 0.0;
  return std::max(prior.start.head<2>().norm(), spread) + settings_.coarse_distance + 4.0 * settings_.wide_sigma;
}

/// Four times the coarse search: what it finds by chance is no reason to look everywhere.
bool ScanMatcher::is_wide(const MatchPrior& prior) const {
  constexpr double kFar = 4.0;
  const double distance = kFar * settings_.coarse_distance;
  const double angle = kFar * settings_.coarse_angle;
  return settings_.spread_draws > 0 &&
         (std::max(prior.P(0, 0), prior.P(1, 1)) > distance * distance || prior.P(2, 2) > angle * angle);
}

Eigen::Vector3d ScanMatcher::spread(const MatchTarget& target, const MatchPrior& prior) const {
  // The start is the host's draw for this particle and step: a key of its own for the stream.
  // Where only the heading is uncertain x and y are zero for all.
  const auto turn = std::bit_cast<std::uint64_t>(prior.start.z());
  Random random({std::bit_cast<std::uint64_t>(prior.start.x()), static_cast<std::uint32_t>(turn),
                 std::bit_cast<std::int64_t>(prior.start.y()), static_cast<std::uint32_t>(turn >> 32)});
  const Eigen::Matrix3d B = gaussian::square_root(prior.P);
  Eigen::Vector3d best = prior.start;
  double best_sum = target.sum_likelihood(wide_, prior.mean + best);
  for (int k = 0; k < settings_.spread_draws; ++k) {
    Eigen::Vector3d d = B * gaussian::standard_normal(random);
    d.z() = so3::wrap(d.z());
    const double sum = target.sum_likelihood(wide_, prior.mean + d);
    if (sum <= best_sum) continue;
    best_sum = sum;
    best = d;
  }
  return best;
}

void ScanMatcher::descend(const MatchTarget& target, const MatchPrior& prior, Eigen::Vector3d d, Match& out) const {
  const double kappa = settings_.curvature_scale;
  Eigen::Matrix3d information;
  Eigen::Vector3d pull;  // P⁻¹ d, which exists where P does not have an inverse
  FieldFit fit;
  for (const bool narrow : {false, true}) {
    for (int i = 0; i < settings_.max_iterations; ++i) {
      fit = target.fit(narrow ? narrow_ : wide_, prior.mean + d);
      information = kappa * fit.JtJ;
      const Eigen::Vector3d gradient = information * d + kappa * fit.Jtr;
      pull = (Eigen::Matrix3d::Identity() + information * prior.P).partialPivLu().solve(gradient);
      const Eigen::Vector3d next = prior.P * pull;
      const Eigen::Vector3d step = next - d;
      d = next;
      if (is_small(step, narrow ? kNarrowStep : kWideStep)) break;
    }
  }
  out.d = d;
  out.score = fit.score;
  out.failed = !d.allFinite() || fit.score < settings_.min_score;
  if (out.failed) return;
  const Weakest weak = weakest(target, wide_, prior.mean + d, information, settings_.wide_sigma);
  if (weak.share < 1.0) {
    // What the scan says of its best place, without that of the weak direction; then with the prior again.
    const gaussian::Eigen3 eigen = gaussian::eigen(information);
    const Eigen::Vector3d inverse = eigen.values.unaryExpr([](double l) { return l > 0.0 ? 1.0 / l : 0.0; });
    const Eigen::Vector3d best = d + eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose() * pull;
    Eigen::Matrix3d kept = Eigen::Matrix3d::Identity();
    kept.topLeftCorner<2, 2>() -= (1.0 - std::sqrt(weak.share)) * weak.direction * weak.direction.transpose();
    information = kept * information * kept;
    pull = (Eigen::Matrix3d::Identity() + information * prior.P).partialPivLu().solve(information * best);
    d = prior.P * pull;
    fit = target.fit(narrow_, prior.mean + d);
    out.d = d;
    out.score = fit.score;
  }
  out.information = with_floor(information, settings_.floor);
  out.gradient = out.information * d + pull;
  out.log_evidence = settings_.evidence_tempering * fit.log_likelihood - 0.5 * pull.dot(d);
}

Eigen::Vector3d ScanMatcher::search(const MatchTarget& target, const MatchPrior& prior) const {
  const double step = std::max(resolution_, MatchSettings::kSearchStep * settings_.wide_sigma);
  const int shifts = static_cast<int>(settings_.coarse_distance / step);
  const int turns = static_cast<int>(settings_.coarse_angle / MatchSettings::kSearchYawStep);
  Eigen::Vector3d best = prior.start;
  double best_sum = -1.0;
  for (int turn = -turns; turn <= turns; ++turn) {
    for (int y = -shifts; y <= shifts; ++y) {
      for (int x = -shifts; x <= shifts; ++x) {
        const Eigen::Vector3d d =
            prior.start + Eigen::Vector3d(x * step, y * step, turn * MatchSettings::kSearchYawStep);
        const double sum = target.sum_likelihood(wide_, prior.mean + d);
        if (sum <= best_sum) continue;
        best_sum = sum;
        best = d;
      }
    }
  }
  return best;
}

Match ScanMatcher::match(const MatchTarget& target, const MatchPrior& prior) const {
  Match match;
  match.searched = is_wide(prior);
  descend(target, prior, match.searched ? spread(target, prior) : prior.start, match);
  if (!match.searched && (match.failed || match.score < settings_.search_score)) {
    // A descent that ended in a wrong place can fit half of the points.
    Match searched;
    descend(target, prior, search(target, prior), searched);
    if (match.failed || (!searched.failed && searched.score > match.score)) match = searched;
    match.searched = true;
  }
  if (!match.failed) return match;
  const FieldFit fit = target.fit(narrow_, prior.mean);
  match.d.setZero();
  match.score = fit.score;
  match.log_evidence = settings_.evidence_tempering * fit.log_likelihood;
  return match;
}

}  // namespace waymark::grid
