// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/match_record.hpp"

#include <algorithm>
#include <memory>

#include "waymark/math/so3.hpp"

namespace waymark::scan_matching {

namespace {

MatchAssociation::Outcome outcome_of(const Match& match) {
  using Kind = MatchAssociation::Outcome::Kind;
  return {match.failed ? Kind::failed : Kind::matched, !match.slip.isZero(0.0), match.score};
}

}  // namespace

MatchAssociation& MatchAssociation::of(Refinement& out) {
  if (!out.association) out.association = std::make_unique<MatchAssociation>();
  auto& association = static_cast<MatchAssociation&>(*out.association);
  association = MatchAssociation{};
  return association;
}

void MatchAssociation::report(const FoundMatch& matches, const Eigen::Matrix3d& R_map_match, Refinement& out) {
  const auto information = [&](const Match& match) -> Eigen::Matrix3d {
    return R_map_match * match.information * R_map_match.transpose();
  };
  const Match& match = matches.match;
  out.information = information(match);
  out.gradient = R_map_match * match.gradient;
  out.log_evidence = match.log_evidence;
  out.failed = match.failed;
  out.searched = match.misfits;
  out.slip = R_map_match * match.slip.asDiagonal() * R_map_match.transpose();
  if (matches.expected) {
    const Match& expected = *matches.expected;
    out.jump = {.d = R_map_match * match.d,
                .information = information(expected),
                .gradient = R_map_match * expected.gradient,
                .log_evidence = expected.log_evidence,
                .failed = expected.failed};
  }
  found = outcome_of(match);
  if_refused = outcome_of(matches.expected ? *matches.expected : match);
  searched = match.searched;
}

void MatchRecord::count(const MatchAssociation& how) {
  using Kind = MatchAssociation::Outcome::Kind;
  const MatchAssociation::Outcome& used = how.refused ? how.if_refused : how.found;
  matches_ += used.kind == Kind::matched;
  failed_ += used.kind == Kind::failed;
  searches_ += how.searched;
  slips_ += used.slipped;
  if (used.kind == Kind::matched) score_sum_ += used.score;
}

void MatchRecord::describe(std::vector<MapFigure>& out) const {
  out.push_back({"matches", static_cast<double>(matches_)});
  out.push_back({"failed_matches", static_cast<double>(failed_)});
  out.push_back({"coarse_searches", static_cast<double>(searches_)});
  out.push_back({"slips", static_cast<double>(slips_)});
  out.push_back({"mean_score", score_sum_ / std::max(1.0, static_cast<double>(matches_))});
}

MatchPrior planar_prior(const PoseGaussian& prior, const Pose& start) {
  const auto planar = [](const Pose& pose) { return Eigen::Vector3d(pose.p.x(), pose.p.y(), pose.yaw()); };
  MatchPrior own{planar(prior.T_map_base), prior.P, planar(start)};
  own.start -= own.mean;
  own.start.z() = so3::wrap(own.start.z());
  return own;
}

}  // namespace waymark::scan_matching
