// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/scan_matcher.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "map_modules/shared/scan_matching/coarse_search.hpp"
#include "map_modules/shared/scan_matching/prior_spread.hpp"
#include "map_modules/shared/scan_matching/slip.hpp"
#include "map_modules/shared/scan_matching/weak_direction.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::scan_matching {

namespace {

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

/// Mean of L of the points that end where the map is known. What would have to look through a wall does not fit there.
double score(const MatchTarget& target, const FieldFit& fit, const Eigen::Vector3d& xyyaw) {
  if (fit.unknown == 0.0) return fit.score;
  const double known = 1.0 - fit.unknown;
  const double judged = known + target.blocked_share(xyyaw, Ends::in_unknown);
  return judged > 0.0 ? fit.score * known / judged : 0.0;
}

/// Whether a scan that does not fit contradicts the map. What ends before what the map shows may be new, as people are.
bool contradicts(const MatchTarget& target, const Eigen::Vector3d& xyyaw) {
  constexpr double kMostBlocked = 0.1;  // half of the scans that fit have less than 0.05
  return target.blocked_share(xyyaw, Ends::anywhere) > kMostBlocked;
}

constexpr double kMostUnknown = 0.85;  // with fewer points in known places chance decides

}  // namespace

ScanMatcher::ScanMatcher(const MatchSettings& settings, double resolution)
    : settings_(settings),
      resolution_(resolution),
      tables_{LikelihoodTable(settings.wide_sigma, resolution), LikelihoodTable(settings.narrow_sigma, resolution)} {}

double ScanMatcher::margin(const MatchPrior& prior) const {
  return std::max(prior.start.head<2>().norm(), spread_reach(prior, settings_)) + settings_.coarse_distance +
         4.0 * settings_.wide_sigma;
}

FoundMatch ScanMatcher::match(const MatchTarget& target, const MatchPrior& prior) const {
  const bool wide = is_wide(prior, settings_);
  const Eigen::Vector3d start = wide ? best_draw(target, prior, tables_.wide, settings_.spread_draws) : prior.start;
  const Match first = match_or_slip_from(target, prior, start);
  Match match = first;
  // A descent that ended in a wrong place can fit half of the points.
  const bool needs_search = !wide && !fits(match);
  if (needs_search) {
    const CoarseSearch search(target, prior, tables_.wide, settings_, resolution_);
    const FoundPlace near = search.near();
    const Match searched = match_or_slip_from(target, prior, near.d);
    if (match.failed || (!searched.failed && searched.score > match.score)) match = searched;
    if (!fits(match)) {
      const FoundPlace farther = search.farther(near);
      if (farther.likelihood > near.likelihood) {
        const Match turned = match_or_slip_from(target, prior, farther.d);
        // So far from the prior only what fits as other scans do counts.
        if (!turned.failed && turned.score >= settings_.search_score) match = turned;
      }
    }
    if (match.failed && may_have_slipped(prior, settings_)) match = search_slipped(target, prior);
  }
  if (match.failed) match = prior_alone(target, prior);
  const bool jumps = !is_expected(prior, match.d);
  match.searched = wide || needs_search;
  match.misfits = needs_search && (jumps || (!fits(match) && contradicts(target, prior.mean + match.d)));
  FoundMatch found{match};
  if (jumps && !wide) {
    const bool first_is_expected = !first.failed && is_expected(prior, first.d);
    found.expected = first_is_expected ? first : prior_alone(target, prior);
  }
  return found;
}

bool ScanMatcher::is_expected(const MatchPrior& prior, const Eigen::Vector3d& d) const {
  constexpr double kGate = 11.3;  // χ², 99 % of three degrees of freedom
  Eigen::Matrix3d P = prior.P;
  P.diagonal() += settings_.floor.cwiseAbs2();
  return d.dot(P.llt().solve(d)) < kGate;
}

bool ScanMatcher::fits(const Match& match) const { return !match.failed && match.score >= settings_.search_score; }

Match ScanMatcher::match_or_slip_from(const MatchTarget& target, const MatchPrior& prior,
                                      const Eigen::Vector3d& start) const {
  Match match = match_from(target, prior, start);
  if (!may_have_slipped(prior, settings_) || (!match.failed && is_expected(prior, match.d))) return match;
  const Match none = prior_alone(target, prior);
  const bool fits_at_mean = none.score >= settings_.min_score;
  if (!match.failed && (fits_at_mean || match.log_evidence >= none.log_evidence)) return match;
  // A slip must explain the scan better than that it fits nothing.
  const Match slipped = slipped_match_from(target, prior, start);
  if (!slipped.failed && slipped.log_evidence > none.log_evidence) match = slipped;
  return match;
}

Match ScanMatcher::match_from(const MatchTarget& target, const MatchPrior& prior, const Eigen::Vector3d& start) const {
  Match match;
  Optimum optimum = descend(target, prior, start, tables_, settings_);
  match.failed = !optimum.d.allFinite() || optimum.fit.unknown > kMostUnknown;
  if (match.failed) return match;
  match.score = score(target, optimum.fit, prior.mean + optimum.d);
  match.failed = match.score < settings_.min_score;
  if (match.failed) return match;
  const WeakDirection weak =
      find_weak_direction(target, tables_.wide, prior.mean + optimum.d, optimum.information, settings_.wide_sigma);
  if (weak.share < 1.0) {
    optimum = without_weak_direction(optimum, weak, target, prior, tables_.narrow);
    match.score = score(target, optimum.fit, prior.mean + optimum.d);
  }
  match.d = optimum.d;
  match.information = with_floor(optimum.information, settings_.floor);
  match.gradient = match.information * optimum.d + optimum.pull;
  match.log_evidence = settings_.evidence_tempering * optimum.fit.log_likelihood - 0.5 * optimum.pull.dot(optimum.d);
  return match;
}

Match ScanMatcher::slipped_match_from(const MatchTarget& target, const MatchPrior& prior,
                                      const Eigen::Vector3d& start) const {
  Match match = match_from(target, after_slip(prior, settings_), start);
  match.log_evidence += kSlipLogProbability;
  match.slip = slip_variance(settings_);
  return match;
}

Match ScanMatcher::search_slipped(const MatchTarget& target, const MatchPrior& prior) const {
  constexpr int kSlipDraws = 4;  // the space is small, and every particle has draws of its own
  const int draws = settings_.spread_draws / kSlipDraws;
  Match match = slipped_match_from(target, prior, best_draw(target, after_slip(prior, settings_), tables_.wide, draws));
  match.failed = match.failed || match.score < settings_.search_score;
  return match;
}

Match ScanMatcher::prior_alone(const MatchTarget& target, const MatchPrior& prior) const {
  const FieldFit fit = target.fit(tables_.narrow, prior.mean);
  Match match;
  match.failed = true;
  match.score = score(target, fit, prior.mean);
  match.log_evidence = settings_.evidence_tempering * fit.log_likelihood;
  return match;
}

}  // namespace waymark::scan_matching
