// SPDX-License-Identifier: Apache-2.0
#include "joint/anchors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "joint/twist.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::joint {

namespace {

constexpr std::size_t kMostAnchors = 150;  // with more, every step would take longer
constexpr std::size_t kMostRelated = 3;    // anchors per scan
constexpr double kLeastShare = 0.15;       // of the points: an anchor with less is left out
/// Places farther from the pose than this, in spacings, are claimed from nearer by: their distance adds to their error.
constexpr double kClaimReach = 2.0;

Eigen::Vector2d position_of(const JointGaussian& gaussian) { return gaussian.belief().mean.T_map_base.p.head<2>(); }

}  // namespace

void Anchors::relate(JointGaussian& gaussian, const Eigen::Matrix3d& information,
                     std::span<const Eigen::Vector2d> points) {
  shares_.clear();
  for (const Eigen::Vector2d& point : points) {
    const int anchor = places_.find(PlaceGrid::place_of(point));
    if (anchor == PlaceGrid::kNone) continue;
    const auto known = std::ranges::find(shares_, anchor, &Share::anchor);
    if (known == shares_.end()) {
      shares_.push_back({anchor, 1});
    } else {
      ++known->points;
    }
  }
  std::ranges::sort(shares_, [](const Share& a, const Share& b) {
    return a.points != b.points ? a.points > b.points : a.anchor < b.anchor;
  });
  if (shares_.size() > kMostRelated) shares_.resize(kMostRelated);
  const int most = shares_.empty() ? 0 : shares_.front().points;
  std::erase_if(shares_, [&](const Share& share) { return share.points < kLeastShare * most; });
  double sum = 0.0;
  for (const Share& share : shares_) sum += share.points;

  const gaussian::Eigen3 eigen = gaussian::eigen(information);
  const Eigen::Matrix3d T = error_of_twist(position_of(gaussian));
  for (const Share& share : shares_) {
    const Eigen::Vector3d root = (eigen.values * (share.points / sum)).cwiseSqrt();
    const Eigen::Matrix3d whitened = root.asDiagonal() * eigen.vectors.transpose();
    gaussian.relate(whitened, {{anchors_[static_cast<std::size_t>(share.anchor)].node, -whitened * T}});
  }
}

void Anchors::claim(JointGaussian& gaussian, std::span<const Eigen::Vector2d> points) {
  choose_active(gaussian);
  const Eigen::Vector2d position = position_of(gaussian);
  const double reach = kClaimReach * settings_.anchor_spacing;
  for (const Eigen::Vector2d& point : points) {
    if ((point - position).squaredNorm() <= reach * reach) places_.claim(PlaceGrid::place_of(point), active_);
  }
}

int Anchors::nearest(const Eigen::Vector2d& p_map, double within) const {
  int best = PlaceGrid::kNone;
  double least = within * within;
  for (std::size_t i = 0; i < anchors_.size(); ++i) {
    const double distance = (anchors_[i].p_map - p_map).squaredNorm();
    if (distance > least) continue;
    least = distance;
    best = static_cast<int>(i);
  }
  return best;
}

/// The active anchor stays while it is near. Else it is the nearest one that the last scan was related to, or a new
/// one.
void Anchors::choose_active(JointGaussian& gaussian) {
  const Eigen::Vector2d position = position_of(gaussian);
  if (active_ != PlaceGrid::kNone && (anchors_[static_cast<std::size_t>(active_)].p_map - position).norm() <= spacing_)
    return;
  const int near = nearest(position, spacing_);
  if (near != PlaceGrid::kNone && std::ranges::find(shares_, near, &Share::anchor) != shares_.end()) {
    active_ = near;
    return;
  }
  if (anchors_.size() >= kMostAnchors) thin(gaussian);
  const Eigen::Matrix3d G = twist_of_error(position);
  const Eigen::Vector3d sigma(settings_.anchor_sigma, settings_.anchor_sigma, settings_.anchor_yaw_sigma);
  const Eigen::Matrix3d noise = sigma.cwiseAbs2().asDiagonal();
  anchors_.push_back({gaussian.add_node(G, G * noise * G.transpose()), position});
  active_ = static_cast<int>(anchors_.size()) - 1;
}

/// Too many anchors: those nearer to an earlier one than a larger spacing give their places to it.
void Anchors::thin(JointGaussian& gaussian) {
  spacing_ *= 1.5;
  for (std::size_t i = 1; i < anchors_.size();) {
    int keeper = PlaceGrid::kNone;
    double least = spacing_ * spacing_;
    for (std::size_t k = 0; k < i; ++k) {
      const double distance = (anchors_[k].p_map - anchors_[i].p_map).squaredNorm();
      if (distance > least) continue;
      least = distance;
      keeper = static_cast<int>(k);
    }
    if (keeper == PlaceGrid::kNone) {
      ++i;
      continue;
    }
    gaussian.remove_node(anchors_[i].node);
    anchors_.erase(anchors_.begin() + static_cast<std::ptrdiff_t>(i));
    places_.remove(static_cast<int>(i), keeper);
  }
  active_ = PlaceGrid::kNone;
}

void Anchors::clear() {
  anchors_.clear();
  places_.clear();
  shares_.clear();
  active_ = PlaceGrid::kNone;
  spacing_ = settings_.anchor_spacing;
}

template <class Archive>
void Anchors::serialize(Archive& archive, const JointGaussian& gaussian) {
  archive.section("anchors", 1);
  archive.each(anchors_, [](auto& each, Anchor& anchor) { each(anchor.node, anchor.p_map); });
  archive(spacing_, active_);
  places_.serialize(archive);
  if constexpr (Archive::kReads) {
    const auto count = static_cast<int>(anchors_.size());
    const bool fits =
        active_ >= PlaceGrid::kNone && active_ < count && places_.largest() < count && std::isfinite(spacing_) &&
        spacing_ > 0.0 &&
        std::ranges::all_of(anchors_, [&](const Anchor& anchor) { return gaussian.has_node(anchor.node); });
    if (!fits) throw DataError("the checkpoint has anchors that do not fit its joint Gaussian");
    shares_.clear();
  }
}
template void Anchors::serialize(OutArchive& archive, const JointGaussian& gaussian);
template void Anchors::serialize(InArchive& archive, const JointGaussian& gaussian);

}  // namespace waymark::joint
