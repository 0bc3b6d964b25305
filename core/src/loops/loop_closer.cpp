// SPDX-License-Identifier: Apache-2.0
#include "loops/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace waymark::loops {

namespace {

constexpr double kNodeSpacing = 1.0;  // of way between nodes [m]
// Of a robot that stands so many keyframes are kept: the scans of several scanners.
constexpr std::size_t kMostAtOnePlace = 20;
constexpr double kAtOnePlace = 0.02;      // [m]
constexpr double kAtOnePlaceTurn = 0.01;  // [rad]
constexpr double kWindow = 5.0;           // of way on both sides of a window's middle [m]
constexpr std::size_t kSearchEvery = 3;   // nodes
constexpr double kSigmas = 3.0;
constexpr double kLeastSearch = 0.6;  // [m]
constexpr double kLeastTurn = 0.05;   // [rad]
constexpr double kKnown = 0.15;       // σ of a place that other loops relate so well [m]: a match would say little
constexpr double kOtherPass = 10.0;   // way between two old places that are both searched [m]
constexpr std::size_t kMostCandidates = 4;
constexpr double kPlausible =
    4 * 16.3;                       // χ² of a match: 99.9 % of three degrees of freedom, of a path with twice its σ
constexpr double kConfirms = 11.3;  // χ² of a match against the poses as they are, 99 %
constexpr double kConfirmsWithin = 0.3;  // [m]
constexpr std::size_t kEnough = 3;       // matches that agree
constexpr double kEnoughWay = 9.0;       // which they span [m]
constexpr std::size_t kMostPending = 16;
constexpr double kPendingFor = 40.0;      // of way [m]
constexpr std::size_t kSearchAgain = 30;  // nodes before a correction that had the wrong place
/// A place that is so near, seen in nearly the same direction and so well known, is expected to look as before.
constexpr double kExpectedWithin = 2.0;  // [m]
constexpr double kExpectedTurn = 0.8;    // [rad]
constexpr double kExpectedSigma = 0.35;  // [m]
constexpr int kMostDoublings = 3;        // of the search, while places are missed
/// χ² of a loop against the path, 99.9 %: beyond, the path was less certain than thought.
constexpr double kDoubts = 16.3;

/// A pose between two nodes, after both were moved.
Eigen::Vector3d carried(const Eigen::Vector3d& pose, const Eigen::Vector3d& before_a, const Eigen::Vector3d& after_a,
                        const Eigen::Vector3d& before_b, const Eigen::Vector3d& after_b, double share) {
  const Eigen::Vector3d by_a = compose(after_a, between(before_a, pose));
  const Eigen::Vector3d by_b = compose(after_b, between(before_b, pose));
  return interpolate(by_a, by_b, share);
}

}  // namespace

void LoopCloser::clear() {
  keyframes_.clear();
  nodes_.clear();
  searched_ = 0;
  frozen_.clear();
  loops_.clear();
  pending_.clear();
  accepted_.reset();
  candidates_.clear();
  misses_ = false;
  found_ = false;
  missed_ = 0;
  again_from_ = 0;
}

void LoopCloser::add(Keyframe keyframe) {
  if (!keyframes_.empty()) {
    Keyframe& last = keyframes_.back();
    if (stands_at(keyframe.xyyaw)) {
      last.P += keyframe.P;
      return;
    }
    const Eigen::Vector3d step = between(last.xyyaw, keyframe.xyyaw);
    keyframe.way = last.way + step.head<2>().norm() + kArm * std::abs(step.z());
  }
  keyframes_.push_back(std::move(keyframe));
  if (nodes_.empty() || keyframes_.back().way - keyframes_[nodes_.back()].way >= kNodeSpacing)
    nodes_.push_back(keyframes_.size() - 1);
}

/// True if there are keyframes enough from there.
bool LoopCloser::stands_at(const Eigen::Vector3d& xyyaw) const {
  if (keyframes_.size() < kMostAtOnePlace) return false;
  const Eigen::Vector3d moved = between(keyframes_[keyframes_.size() - kMostAtOnePlace].xyyaw, xyyaw);
  return moved.head<2>().norm() < kAtOnePlace && std::abs(moved.z()) < kAtOnePlaceTurn;
}

void LoopCloser::bound() {
  if (!is_full()) return;
  thin(keyframes_.size() / 2);
  for (std::size_t before = 0; is_full() && keyframes_.size() != before;) {
    before = keyframes_.size();
    thin(keyframes_.size());
  }
}

std::vector<Eigen::Vector3d> LoopCloser::carry(std::size_t last, std::span<const StampedPose> path) {
  const std::span<Keyframe> moving = std::span(keyframes_).subspan(last);
  const Eigen::Vector3d to = moving.front().xyyaw;
  follow(moving, path);
  std::vector<Eigen::Vector3d> before;
  before.reserve(moving.size());
  for (Keyframe& keyframe : moving) {
    before.push_back(keyframe.xyyaw);
    keyframe.xyyaw = compose(to, between(before.front(), keyframe.xyyaw));
  }
  return before;
}

/// Of those before `end`, every second keyframe that is no node goes, but not the last of all. What it adds to the
/// error of the path stays.
void LoopCloser::thin(std::size_t end) {
  std::vector<Keyframe> kept;
  std::vector<std::size_t> nodes;
  kept.reserve(keyframes_.size());
  nodes.reserve(nodes_.size());
  auto node = nodes_.begin();
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  bool goes = false;
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    const bool is_node = node != nodes_.end() && *node == i;
    P += keyframes_[i].P;
    if (!is_node && i < end && i + 1 < keyframes_.size()) {
      goes = !goes;
      if (goes) continue;
    }
    if (is_node) {
      nodes.push_back(kept.size());
      ++node;
    }
    kept.push_back(std::move(keyframes_[i]));
    kept.back().P = P;
    P.setZero();
  }
  keyframes_ = std::move(kept);
  nodes_ = std::move(nodes);
}

bool LoopCloser::is_next_due() const {
  const std::size_t next = searched_ + kSearchEvery;
  return next < nodes_.size() && keyframes_.back().way - keyframes_[nodes_[next]].way >= kWindow;
}

/// What the path says, with the noise that its mapping steps added.
Relation LoopCloser::step(std::size_t from_keyframe, std::size_t to_keyframe) const {
  const Keyframe& from = keyframes_[from_keyframe];
  const Keyframe& to = keyframes_[to_keyframe];
  Relation relation{between(from.xyyaw, to.xyyaw), Eigen::Matrix3d::Zero()};
  for (std::size_t i = from_keyframe + 1; i <= to_keyframe; ++i) {
    const Keyframe& at = keyframes_[i];
    Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
    const Eigen::Vector2d arm = to.xyyaw.head<2>() - at.xyyaw.head<2>();
    J(0, 2) = -arm.y();
    J(1, 2) = arm.x();
    relation.P += J * at.P * J.transpose();
  }
  const Eigen::Matrix3d R = turn(from.xyyaw.z()).transpose();
  relation.P = R * relation.P * R.transpose();
  const double share = (to.way - from.way) / noise_.anchor_spacing;
  relation.P.diagonal() +=
      share * Eigen::Vector3d(noise_.anchor_sigma, noise_.anchor_sigma, noise_.anchor_yaw_sigma).cwiseAbs2();
  return relation;
}

std::vector<Relation> LoopCloser::steps() const {
  std::vector<Relation> steps = frozen_;
  steps.reserve(nodes_.size());
  for (std::size_t k = steps.size(); k + 1 < nodes_.size(); ++k) steps.push_back(step(nodes_[k], nodes_[k + 1]));
  return steps;
}

/// Older nodes that may be where this one is, and are not yet known to be: the nearest ones of different passes.
std::vector<std::size_t> LoopCloser::candidates(std::size_t node, std::span<const Relation> from_node) const {
  std::vector<std::size_t> found;
  const Keyframe& own = keyframe(node);
  const auto distance = [&](std::size_t k) { return (keyframe(k).xyyaw - own.xyyaw).head<2>().norm(); };
  for (std::size_t round = 0; round < kMostCandidates; ++round) {
    double least = settings_.search_distance;
    std::optional<std::size_t> nearest;
    for (std::size_t k = 0; k < node && own.way - keyframe(k).way >= settings_.least_way; ++k) {
      const auto is_same_pass = [&](std::size_t other) {
        return std::abs(keyframe(other).way - keyframe(k).way) < kOtherPass;
      };
      if (distance(k) >= least || std::ranges::any_of(found, is_same_pass)) continue;
      const double sigma = std::sqrt(position_variance(from_node[k].P));
      if (distance(k) > kSigmas * sigma + kWindow) continue;
      least = distance(k);
      nearest = k;
    }
    if (!nearest) break;
    found.push_back(*nearest);
  }
  std::erase_if(found, [&](std::size_t k) { return position_variance(from_node[k].P) < kKnown * kKnown; });
  return found;
}

bool LoopCloser::is_expected(std::size_t old_node, std::size_t node, const Relation& to_old) const {
  const Eigen::Vector3d apart = between(keyframe(old_node).xyyaw, keyframe(node).xyyaw);
  return apart.head<2>().norm() < kExpectedWithin && std::abs(apart.z()) < kExpectedTurn &&
         position_variance(to_old.P) < kExpectedSigma * kExpectedSigma;
}

/// While places are missed, the path may be torn: the search is wider than its σ.
LoopCloser::Search LoopCloser::match(std::size_t old_node, std::size_t node, const Relation& to_old) {
  const Eigen::Vector3d prior = between(keyframe(old_node).xyyaw, keyframe(node).xyyaw);
  const Eigen::Matrix3d of_path = inverse(to_old).P;
  Eigen::Matrix3d P = of_path;
  const double wider = is_doubted() ? (1 << std::min(missed_ - 1, kMostDoublings)) / kSigmas : 0.0;
  P.diagonal() += wider * wider * Eigen::Vector3d(kLeastSearch, kLeastSearch, kLeastTurn).cwiseAbs2();
  const double sigma = std::sqrt(position_variance(P));
  const SearchRange range{std::clamp(kSigmas * sigma, kLeastSearch, settings_.search_distance),
                          std::clamp(kSigmas * std::sqrt(P(2, 2)), kLeastTurn, settings_.search_angle)};
  matcher_.draw(window(keyframes_, nodes_[old_node], kWindow));
  const WindowSearch found = matcher_.match(window(keyframes_, nodes_[node], kWindow), prior, range);
  Search search{.loop = std::nullopt, .misses = !found.is_ambiguous && is_expected(old_node, node, to_old)};
  if (!found.match) return search;
  const Relation& relation = found.match->relation;
  const Eigen::Vector3d off = difference(relation.z, prior);
  const auto chi_squared = [&](const Eigen::Matrix3d& path) { return off.dot((relation.P + path).inverse() * off); };
  if (chi_squared(P) > kPlausible) return search;
  search.loop = Loop{old_node, node, relation, chi_squared(of_path)};
  search.misses = search.misses && search.loop->path_chi_squared > kDoubts;
  return search;
}

/// True if this loop makes a set that agrees large enough.
bool LoopCloser::accept(const Loop& loop, std::span<const Eigen::Vector3d> poses, std::span<const Relation> steps) {
  const Eigen::Vector3d off = between(poses[loop.from], poses[loop.to]) - loop.relation.z;
  if (off.head<2>().norm() < kConfirmsWithin && PoseGraph::chi_squared(loop, poses) < kConfirms) {
    loops_.push_back(loop);
    return false;
  }
  const double driven = keyframe(loop.to).way;
  std::erase_if(pending_, [&](const Loop& old) { return driven - keyframe(old.to).way > kPendingFor; });
  if (pending_.size() >= kMostPending) pending_.erase(pending_.begin());
  pending_.push_back(loop);
  const std::vector<std::size_t> set = agreeing(pending_, steps);
  if (set.size() < kEnough ||
      keyframe(pending_[set.back()].to).way - keyframe(pending_[set.front()].to).way < kEnoughWay)
    return false;
  for (const std::size_t i : set) loops_.push_back(pending_[i]);
  pending_.clear();
  return true;
}

/// The last node that a loop relates to older ones.
std::size_t LoopCloser::last_recognised() const {
  std::size_t last = 0;
  for (const Loop& loop : loops_) last = std::max(last, loop.to);
  return last;
}

bool LoopCloser::is_bridged(Time stamp) const {
  return std::ranges::any_of(
      loops_, [&](const Loop& loop) { return keyframe(loop.from).stamp < stamp && stamp < keyframe(loop.to).stamp; });
}

/// Begins the next node, or goes on with one: a candidate costs milliseconds, and a mapping step has few.
void LoopCloser::search_some() {
  const std::vector<Relation> all_steps = steps();
  do {
    const bool begins = candidates_.empty();
    if (begins) searched_ += kSearchEvery;
    const std::vector<Relation> from_node = PoseGraph(all_steps, loops_).relations_from(searched_);
    if (begins) begin_node(from_node);
    if (candidates_.empty()) return;
    search_candidate(from_node, all_steps);
    if (candidates_.empty()) conclude_node();
  } while (!accepted_ && !candidates_.empty() && is_next_due());
}

void LoopCloser::begin_node(std::span<const Relation> from_node) {
  candidates_ = candidates(searched_, from_node);
  std::ranges::reverse(candidates_);
  misses_ = false;
  found_ = false;
}

void LoopCloser::search_candidate(std::span<const Relation> from_node, std::span<const Relation> steps) {
  const std::size_t old_node = candidates_.back();
  candidates_.pop_back();
  const Search search = match(old_node, searched_, from_node[old_node]);
  misses_ = misses_ || search.misses;
  if (!search.loop) return;
  found_ = found_ || search.loop->path_chi_squared < kDoubts;
  const Accepted accepted{loops_.size(), last_recognised(), is_doubted()};
  if (!accept(*search.loop, poses(), steps)) return;
  found_ = true;
  accepted_ = accepted;
  candidates_.clear();
}

void LoopCloser::conclude_node() {
  if (found_) {
    missed_ = 0;
  } else if (misses_) {
    missed_ = std::min(missed_ + 1, kMostMissed);
  }
}

std::vector<Eigen::Vector3d> LoopCloser::poses() const {
  std::vector<Eigen::Vector3d> poses;
  poses.reserve(nodes_.size());
  for (std::size_t k = 0; k < nodes_.size(); ++k) poses.push_back(keyframe(k).xyyaw);
  return poses;
}

/// A path that is torn was less certain than thought since the last place was recognised: new loops show how much.
void LoopCloser::doubt(std::vector<Relation>& steps, std::size_t since, std::size_t old_loops) const {
  double most = 0.0;
  for (const Loop& loop : std::span(loops_).subspan(old_loops)) most = std::max(most, loop.path_chi_squared);
  if (most < kDoubts) return;
  for (Relation& step : std::span(steps).subspan(since)) step.P *= most / 3.0;
}

std::optional<Correction> LoopCloser::correct() {
  std::vector<Relation> steps = this->steps();
  if (accepted_->path_is_doubted) doubt(steps, accepted_->recognised, accepted_->old_loops);
  accepted_.reset();
  const std::vector<Eigen::Vector3d> before = poses();
  std::vector<Eigen::Vector3d> poses = before;
  PoseGraph(steps, loops_).solve(poses);
  Correction correction;
  for (std::size_t k = 0; k < poses.size(); ++k)
    correction.shift = std::max(correction.shift, (poses[k] - before[k]).head<2>().norm());
  if (correction.shift < settings_.least_shift) return std::nullopt;
  frozen_ = std::move(steps);
  const Loop& last = loops_.back();
  correction.way = keyframe(last.to).way - keyframe(last.from).way;
  correction.before.reserve(keyframes_.size());
  for (const Keyframe& keyframe : keyframes_) correction.before.push_back(keyframe.xyyaw);
  std::size_t k = 0;
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    while (k + 1 < nodes_.size() && nodes_[k + 1] <= i) ++k;
    const bool is_last = k + 1 == nodes_.size();
    const std::size_t next = is_last ? k : k + 1;
    const double length = keyframe(next).way - keyframe(k).way;
    const double share = length > 0.0 ? (keyframes_[i].way - keyframe(k).way) / length : 0.0;
    keyframes_[i].xyyaw = carried(keyframes_[i].xyyaw, before[k], poses[k], before[next], poses[next], share);
  }
  // Where the path was wrong, places were searched in vain: they are searched again, once.
  const std::size_t again = std::max(again_from_, searched_ - std::min(searched_, kSearchAgain));
  again_from_ = searched_;
  searched_ = again;
  return correction;
}

Eigen::MatrixXd LoopCloser::covariance(std::span<const std::size_t> keyframes) const {
  std::vector<std::size_t> nodes;
  nodes.reserve(keyframes.size());
  for (const std::size_t keyframe : keyframes) {
    const auto later = std::ranges::upper_bound(nodes_, keyframe);
    nodes.push_back(static_cast<std::size_t>(later - nodes_.begin()) - 1);
  }
  const std::vector<Relation> steps = this->steps();
  return PoseGraph(steps, loops_).covariance(poses(), nodes);
}

void LoopCloser::rewind(Time stamp) {
  while (!keyframes_.empty() && keyframes_.back().stamp > stamp) keyframes_.pop_back();
  while (!nodes_.empty() && nodes_.back() >= keyframes_.size()) nodes_.pop_back();
  const std::size_t nodes = nodes_.size();
  searched_ = std::min(searched_, nodes == 0 ? 0 : nodes - 1);
  again_from_ = std::min(again_from_, searched_);
  if (frozen_.size() + 1 > nodes) frozen_.resize(nodes == 0 ? 0 : nodes - 1);
  const auto is_gone = [&](const Loop& loop) { return loop.to >= nodes || loop.from >= nodes; };
  std::erase_if(loops_, is_gone);
  std::erase_if(pending_, is_gone);
  accepted_.reset();
  candidates_.clear();
}

}  // namespace waymark::loops
