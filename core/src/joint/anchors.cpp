// SPDX-License-Identifier: Apache-2.0
#include "joint/anchors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "joint/white_match.hpp"
#include "loops/planar.hpp"
#include "loops/twist.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::joint {

namespace {

constexpr std::size_t kMostAnchors = 150;  // with more, every step would take longer
constexpr std::size_t kMostRelated = 3;    // anchors per scan
constexpr double kLeastShare = 0.15;       // of the points: an anchor with less is left out
/// Places farther from the pose than the spacing are claimed from nearer by: their distance adds to their error. On
/// open ground the nearest share of a scan's points is claimed, however far it is.
constexpr double kNearestShare = 0.25;

/// A pose that is less certain than this against a place that it meets again is not taken for being there at once.
constexpr double kUncertain = 0.5;      // [m]
constexpr double kUncertainTurn = 0.1;  // [rad]
constexpr double kMostWaiting = 60.0;   // of way [m]: by then a loop would have been found
constexpr double kMostRefusing = 30.0;  // a loop that is found takes 20: two halves of a window, and what it spans

/// x, y, yaw of the mean.
Eigen::Vector3d pose_of(const JointGaussian& gaussian) { return loops::planar(gaussian.belief().mean.T_map_base); }

}  // namespace

void relate_to_prior_map(JointGaussian& gaussian, const PoseMatch& match) {
  const WhiteMatch white = whiten(match.information, match.gradient);
  gaussian.relate(white.target - white.W * loops::difference(pose_of(gaussian), match.prior), white.W, {});
}

void Anchors::relate(JointGaussian& gaussian, const PoseMatch& match, std::span<const Eigen::Vector2d> points,
                     std::span<const AnchorPose> poses) {
  share(points, shares_);
  std::ranges::sort(shares_, [](const Share& a, const Share& b) {
    return a.points != b.points ? a.points > b.points : a.anchor < b.anchor;
  });
  if (shares_.size() > kMostRelated) shares_.resize(kMostRelated);
  const int most = shares_.empty() ? 0 : shares_.front().points;
  std::erase_if(shares_, [&](const Share& share) { return share.points < kLeastShare * most; });
  double sum = 0.0;
  for (const Share& share : shares_) sum += share.points;
  const double way = way_since_last(match.prior);
  way_ += way;
  if (waiting_since_ && way_ - *waiting_since_ > 2.0 * kMostWaiting) waiting_since_.reset();
  std::erase_if(shares_, [&](const Share& share) {
    return must_wait(gaussian, anchors_[static_cast<std::size_t>(share.anchor)]);
  });

  const WhiteMatch white = whiten(match.information, match.gradient);
  // What is drawn from elsewhere moves what was there. It is no state: a state would take its share of every
  // innovation.
  const Eigen::Matrix3d drawn = way / settings_.anchor_spacing * own_error(pose_of(gaussian).head<2>());
  if (!shares_.empty()) creep_.setZero();
  for (const Share& share : shares_) {
    Anchor& anchor = anchors_[static_cast<std::size_t>(share.anchor)];
    const auto of_particle = std::ranges::find(poses, anchor.node, &AnchorPose::anchor);
    if (of_particle == poses.end()) continue;
    const Eigen::Vector3d correction = gaussian.take_correction(anchor.node);
    anchor.mean += loops::error_of_twist(anchor.mean.head<2>()) * correction;
    anchor.in_map = of_particle->xyyaw.head<2>();
    anchor.creep += share.points / sum * drawn;
    creep_ += share.points / sum * anchor.creep;
    // The pose in the particle's map, whose frame the anchor ties to that of the joint Gaussian.
    const Eigen::Matrix3d R = loops::turn(of_particle->xyyaw.z() - anchor.mean.z());
    const Eigen::Vector3d pose = pose_of(gaussian);
    const Eigen::Vector3d in_map = of_particle->xyyaw + R * (pose - anchor.mean);
    const double root = std::sqrt(share.points / sum);
    const Eigen::Matrix3d rows = root * white.W * R;
    gaussian.relate(root * (white.target - white.W * loops::difference(in_map, match.prior)), rows,
                    {{anchor.node, -rows * loops::error_of_twist(pose.head<2>())}});
  }
}

/// Points by the anchor of the place that they lie in; those in places without one are left out.
void Anchors::share(std::span<const Eigen::Vector2d> points, std::vector<Share>& shares) const {
  shares.clear();
  for (const Eigen::Vector2d& point : points) {
    const int anchor = places_.find(PlaceGrid::place_of(point));
    if (anchor == PlaceGrid::kNone) continue;
    const auto known = std::ranges::find(shares, anchor, &Share::anchor);
    if (known == shares.end()) {
      shares.push_back({anchor, 1});
    } else {
      ++known->points;
    }
  }
}

bool Anchors::must_wait(const JointGaussian& gaussian, Anchor& anchor) {
  if (is_uncertain_return(gaussian, anchor)) {
    if (!waiting_since_) waiting_since_ = way_;
    if (!has_waited(kMostWaiting)) return true;
  }
  anchor.seen = way_;
  return false;
}

bool Anchors::has_waited(double way) const { return waiting_since_ && way_ - *waiting_since_ >= way; }

bool Anchors::is_uncertain_return(const JointGaussian& gaussian, const Anchor& anchor) const {
  if (!return_way_ || way_ - anchor.seen <= *return_way_) return false;
  const Eigen::Matrix3d T = loops::error_of_twist(pose_of(gaussian).head<2>());
  const Eigen::Matrix3d P = gaussian.covariance_against(anchor.node, T);
  return loops::position_variance(P) > kUncertain * kUncertain || P(2, 2) > kUncertainTurn * kUncertainTurn;
}

bool Anchors::returns_uncertainly(const JointGaussian& gaussian, std::span<const Eigen::Vector2d> points) const {
  if (!return_way_ || has_waited(kMostRefusing)) return false;
  std::vector<Share> shares;
  share(points, shares);
  int sure = 0;
  int unsure = 0;
  for (const Share& share : shares) {
    const Anchor& anchor = anchors_[static_cast<std::size_t>(share.anchor)];
    (is_uncertain_return(gaussian, anchor) ? unsure : sure) += share.points;
  }
  return unsure > sure;
}

void Anchors::begin_way() {
  last_.reset();
  waiting_since_.reset();
  for (Anchor& anchor : anchors_) anchor.seen = way_;
}

/// [m]; with turns.
double Anchors::way_since_last(const Eigen::Vector3d& xyyaw) {
  const Eigen::Vector3d d = last_ ? loops::difference(xyyaw, *last_) : Eigen::Vector3d::Zero();
  last_ = xyyaw;
  return d.head<2>().norm() + loops::kArm * std::abs(d.z());
}

std::optional<JointGaussian::NodeId> Anchors::claim(JointGaussian& gaussian, std::span<const Eigen::Vector2d> points,
                                                    const Eigen::Vector2d& position) {
  const auto added = choose_active(gaussian, position);
  claim_within_reach(points, position, active_);
  return added;
}

void Anchors::claim_within_reach(std::span<const Eigen::Vector2d> points, const Eigen::Vector2d& position, int anchor) {
  distances_.clear();
  for (const Eigen::Vector2d& point : points) distances_.push_back((point - position).norm());
  if (distances_.empty()) return;
  const auto nearest =
      distances_.begin() + static_cast<std::ptrdiff_t>(kNearestShare * static_cast<double>(distances_.size()));
  std::ranges::nth_element(distances_, nearest);
  const double reach = std::max(settings_.anchor_spacing, *nearest);
  // Points that follow one another are mostly of one place.
  std::optional<PlaceGrid::Place> last;
  for (const Eigen::Vector2d& point : points) {
    const PlaceGrid::Place place = PlaceGrid::place_of(point);
    if (place == last || (point - position).norm() > reach) continue;
    places_.claim(place, anchor);
    last = place;
  }
}

std::optional<JointGaussian::NodeId> Anchors::active() const {
  if (active_ == PlaceGrid::kNone) return std::nullopt;
  return anchors_[static_cast<std::size_t>(active_)].node;
}

void Anchors::forget_places(std::span<const AnchorPose> poses) {
  places_.clear();
  shares_.clear();
  last_.reset();
  for (Anchor& anchor : anchors_) {
    const auto now = std::ranges::find(poses, anchor.node, &AnchorPose::anchor);
    if (now != poses.end()) anchor.in_map = now->xyyaw.head<2>();
  }
}

void Anchors::begin_anew(JointGaussian& gaussian, const Belief& belief, std::span<const AnchorPose> poses,
                         const Eigen::MatrixXd& P) {
  const std::optional<JointGaussian::NodeId> active_node = active();
  active_ = PlaceGrid::kNone;
  std::vector<Anchor> kept;
  std::vector<JointGaussian::NodeId> nodes;
  std::vector<Eigen::Index> rows;
  Eigen::Index row = 0;
  for (const AnchorPose& pose : poses) {
    const auto own = std::ranges::find(anchors_, pose.anchor, &Anchor::node);
    const bool ascends = nodes.empty() || nodes.back() < pose.anchor;  // a checkpoint can be wrong
    if (own != anchors_.end() && ascends) {
      if (active_node == pose.anchor) active_ = static_cast<int>(kept.size());
      kept.push_back({pose.anchor, pose.xyyaw, pose.xyyaw.head<2>(), Eigen::Matrix3d::Zero(), own->seen});
      nodes.push_back(pose.anchor);
      for (Eigen::Index i = row; i < row + 3; ++i) rows.push_back(i);
    }
    row += 3;
  }
  anchors_ = std::move(kept);
  creep_.setZero();
  waiting_since_.reset();
  forget_places(poses);

  Eigen::MatrixXd between = P(rows, rows);
  for (std::size_t i = 0; i < anchors_.size(); ++i) {
    const auto first = 3 * static_cast<Eigen::Index>(i);
    between.block<3, 3>(first, first) += own_error(anchors_[i].mean.head<2>());
  }
  const Eigen::Matrix3d T = loops::error_of_twist(belief.mean.T_map_base.p.head<2>());
  gaussian.restart(belief, nodes, P(rows, Eigen::seqN(row, 3)) * T.transpose(), between);
}

void Anchors::claim_for(JointGaussian::NodeId node, std::span<const Eigen::Vector2d> points,
                        const Eigen::Vector2d& position) {
  const auto own = std::ranges::find(anchors_, node, &Anchor::node);
  const int anchor = own != anchors_.end() ? static_cast<int>(own - anchors_.begin())
                                           : nearest(position, std::numeric_limits<double>::infinity());
  if (anchor != PlaceGrid::kNone) claim_within_reach(points, position, anchor);
}

Eigen::Matrix3d Anchors::own_error(const Eigen::Vector2d& position) const {
  const Eigen::Matrix3d G = loops::twist_of_error(position);
  return G * noise().asDiagonal() * G.transpose();
}

Eigen::Matrix3d Anchors::local_error(const Eigen::Vector2d& position) const {
  if (anchors_.empty()) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d T = loops::error_of_twist(position);
  Eigen::Matrix3d error = T * creep_ * T.transpose();
  error.diagonal() += noise();
  return error;
}

int Anchors::nearest(const Eigen::Vector2d& position, double within) const {
  int best = PlaceGrid::kNone;
  double least = within * within;
  for (std::size_t i = 0; i < anchors_.size(); ++i) {
    const double distance = (anchors_[i].in_map - position).squaredNorm();
    if (distance > least) continue;
    least = distance;
    best = static_cast<int>(i);
  }
  return best;
}

/// The active anchor stays while it is near. Else it is the nearest one that the last scan was related to, or a new
/// one.
std::optional<JointGaussian::NodeId> Anchors::choose_active(JointGaussian& gaussian, const Eigen::Vector2d& position) {
  if (active_ != PlaceGrid::kNone && (anchors_[static_cast<std::size_t>(active_)].in_map - position).norm() <= spacing_)
    return std::nullopt;
  const int near = nearest(position, spacing_);
  if (near != PlaceGrid::kNone && std::ranges::find(shares_, near, &Share::anchor) != shares_.end()) {
    active_ = near;
    return std::nullopt;
  }
  remove_idle(gaussian);
  if (anchors_.size() >= kMostAnchors) thin(gaussian);
  const Eigen::Vector3d pose = pose_of(gaussian);
  const JointGaussian::NodeId node =
      gaussian.add_node(loops::twist_of_error(pose.head<2>()), own_error(pose.head<2>()));
  anchors_.push_back({node, pose, position, creep_, way_});
  active_ = static_cast<int>(anchors_.size()) - 1;
  return node;
}

/// Too many anchors: those nearer to an earlier one than a larger spacing give their places to it.
void Anchors::thin(JointGaussian& gaussian) {
  spacing_ *= 1.5;
  for (std::size_t i = 1; i < anchors_.size();) {
    int keeper = PlaceGrid::kNone;
    double least = spacing_ * spacing_;
    for (std::size_t k = 0; k < i; ++k) {
      const double distance = (anchors_[k].in_map - anchors_[i].in_map).squaredNorm();
      if (distance > least) continue;
      least = distance;
      keeper = static_cast<int>(k);
    }
    if (keeper == PlaceGrid::kNone) {
      ++i;
      continue;
    }
    remove(gaussian, i, keeper);
  }
}

void Anchors::remove_idle(JointGaussian& gaussian) {
  std::vector<bool> is_owner(anchors_.size());
  places_.for_each_anchor([&](int anchor) { is_owner[static_cast<std::size_t>(anchor)] = true; });
  for (std::size_t i = anchors_.size(); i-- > 0;) {
    if (!is_owner[i]) remove(gaussian, i, PlaceGrid::kNone);
  }
}

void Anchors::remove(JointGaussian& gaussian, std::size_t anchor, int keeper) {
  gaussian.remove_node(anchors_[anchor].node);
  anchors_.erase(anchors_.begin() + static_cast<std::ptrdiff_t>(anchor));
  places_.remove(static_cast<int>(anchor), keeper);
}

void Anchors::clear() {
  anchors_.clear();
  places_.clear();
  shares_.clear();
  active_ = PlaceGrid::kNone;
  last_.reset();
  way_ = 0.0;
  waiting_since_.reset();
  creep_.setZero();
  spacing_ = settings_.anchor_spacing;
}

template <class Archive>
void Anchors::serialize(Archive& archive, const JointGaussian& gaussian) {
  if (archive.section("anchors", 2) < 2) throw DataError("the checkpoint has an older version");
  archive.each(anchors_, [](auto& each, Anchor& anchor) {
    each(anchor.node, anchor.mean, anchor.in_map, anchor.creep, anchor.seen);
  });
  archive(spacing_, active_, last_, creep_, way_, waiting_since_);
  places_.serialize(archive);
  if constexpr (Archive::kReads) {
    const auto count = static_cast<int>(anchors_.size());
    const bool fits = active_ >= PlaceGrid::kNone && active_ < count && places_.largest() < count &&
                      std::isfinite(spacing_) && spacing_ > 0.0 && std::isfinite(way_) &&
                      std::isfinite(waiting_since_.value_or(0.0)) &&
                      std::ranges::all_of(anchors_, [&](const Anchor& anchor) {
                        return gaussian.has_node(anchor.node) && std::isfinite(anchor.seen);
                      });
    if (!fits) throw DataError("the checkpoint has anchors that do not fit its joint Gaussian");
    shares_.clear();
  }
}
template void Anchors::serialize(OutArchive& archive, const JointGaussian& gaussian);
template void Anchors::serialize(InArchive& archive, const JointGaussian& gaussian);

}  // namespace waymark::joint
