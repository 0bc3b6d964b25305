// SPDX-License-Identifier: Apache-2.0
#include "beacon_map.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "waymark/base/error.hpp"

namespace waymark::range_beacons {
namespace {

/// A range that is rather an outlier says nothing about the pose and changes no map.
constexpr double kTrusted = 0.5;
/// After so many of them in a row it is the place that is wrong: the beacon is looked for anew.
constexpr int kLostAfter = 5;

double pose_variance(const PredictedRange& seen, const Antenna& antenna, const Eigen::Matrix3d& pose_P) {
  const Eigen::RowVector3d G = seen.by_antenna * antenna.by_pose;
  return G * pose_P * G.transpose();
}

}  // namespace

BeaconMap::BeaconMap(const Settings& settings)
    : settings_(settings), content_(Content{Survey(settings.scale, settings.scale_sigma), {}}) {}

const Cow<BeaconMap::Beacon>* BeaconMap::find(int number) const {
  const auto& beacons = content_->beacons;
  const auto found = std::ranges::find_if(beacons, [&](const Cow<Beacon>& one) { return one->number == number; });
  return found == beacons.end() ? nullptr : &*found;
}

BeaconMap::Prediction BeaconMap::predict(const Beacon& beacon, const RangeSet::One& range, const Antenna& antenna,
                                         const Eigen::Matrix3d& pose_P) const {
  double log_density = 0.0;
  if (beacon.index < 0) {
    log_density = beacon.ring.log_evidence(range.range_m, range.sigma_m, antenna, pose_P);
  } else {
    const Place place = content_->survey.marginal(beacon.index);
    const PredictedRange seen = place.predict(range.range_m, range.sigma_m, antenna.p);
    const double S = seen.variance + pose_variance(seen, antenna, pose_P);
    log_density = -0.5 * (seen.nu * seen.nu / S + std::log(2.0 * std::numbers::pi * S));
  }
  const double regular = std::log1p(-settings_.outlier_share) + log_density;
  if (settings_.outlier_share == 0.0) return {regular, 1.0};
  const double outlier = std::log(settings_.outlier_share / settings_.range_max_m);
  const double most = std::max(regular, outlier);
  const double both = most + std::log1p(std::exp(-std::abs(regular - outlier)));
  return {both, std::exp(regular - both)};
}

void BeaconMap::refine(const PoseGaussian& prior, const Pose&, const Observation& observation, Refinement& out) const {
  // The ranges of a burst one after the other, each around what those before it made of the pose.
  const Antenna antenna(prior.T_map_base, settings_.p_base_antenna);
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  Eigen::Matrix3d P = prior.P;
  for (const RangeSet::One& range : static_cast<const RangeSet&>(observation).ranges) {
    const Cow<Beacon>* beacon = find(range.beacon);
    if (beacon == nullptr) continue;  // so it is for all particles: the numbers are known
    Antenna at = antenna;
    at.p += antenna.by_pose * moved;
    const Prediction predicted = predict(beacon->read(), range, at, P);
    out.log_evidence += predicted.log_evidence;
    if ((*beacon)->index < 0 || predicted.trust < kTrusted) continue;  // a ring says too little about the pose
    const PredictedRange seen = content_->survey.marginal((*beacon)->index).predict(range.range_m, range.sigma_m, at.p);
    const Eigen::RowVector3d G = seen.by_antenna * antenna.by_pose;
    const Eigen::Vector3d PGt = P * G.transpose();
    const double S = G * PGt + seen.variance;
    out.information += G.transpose() * G / seen.variance;
    out.gradient += G.transpose() * (seen.nu + G * moved) / seen.variance;
    moved += PGt * (seen.nu / S);
    P -= PGt * PGt.transpose() / S;
  }
}

void BeaconMap::insert(const PoseGaussian& pose, const Observation& observation, const Association*) {
  const Antenna antenna(pose.T_map_base, settings_.p_base_antenna);
  for (const RangeSet::One& range : static_cast<const RangeSet&>(observation).ranges) add(range, antenna, pose.P);
}

void BeaconMap::add(const RangeSet::One& range, const Antenna& antenna, const Eigen::Matrix3d& pose_P) {
  const Cow<Beacon>* known = find(range.beacon);
  if (known == nullptr) {
    Content& content = content_.write();
    const Survey& survey = content.survey;
    content.beacons.emplace_back(
        Beacon{range.beacon, -1, 1, 0,
               Ring(range.range_m, range.sigma_m, antenna, pose_P, survey.scale(), survey.scale_variance())});
    return;
  }
  const bool trusted = predict(known->read(), range, antenna, pose_P).trust >= kTrusted;
  const auto place = static_cast<std::size_t>(known - content_->beacons.data());
  Content& content = content_.write();
  Beacon& beacon = content.beacons[place].write();
  beacon.misses = trusted ? 0 : beacon.misses + 1;
  if (!trusted) {
    if (beacon.misses < kLostAfter) return;
    const Survey& survey = content.survey;
    beacon = {range.beacon, -1, 1, 0,
              Ring(range.range_m, range.sigma_m, antenna, pose_P, survey.scale(), survey.scale_variance())};
    return;
  }
  ++beacon.sightings;
  if (beacon.index < 0) {
    beacon.ring.update(range.range_m, range.sigma_m, antenna, pose_P);
    settle(beacon, antenna.p);
    return;
  }
  const PredictedRange seen = content.survey.marginal(beacon.index).predict(range.range_m, range.sigma_m, antenna.p);
  content.survey.update(beacon.index, range.range_m, range.sigma_m, antenna.p, pose_variance(seen, antenna, pose_P));
}

/// Once the places of a ring agree, as seen from the robot, one Gaussian is enough.
void BeaconMap::settle(Beacon& beacon, const Eigen::Vector2d& p_map_antenna) {
  const Place whole = beacon.ring.collapsed();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(whole.P.topLeftCorner<2, 2>(), Eigen::EigenvaluesOnly);
  const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()[1]));
  if (sigma > settings_.settled * (p_map_antenna - whole.mean.head<2>()).norm()) return;
  beacon.index = content_.write().survey.add(beacon.ring);
  beacon.ring = {};
}

void BeaconMap::describe(MapDescription& out) const {
  int rings = 0;
  for (const Cow<Beacon>& beacon : content_->beacons) {
    if (beacon->index < 0) {
      ++rings;
      continue;
    }
    const Place place = content_->survey.marginal(beacon->index);
    LandmarkView view;
    view.id = beacon->number;
    view.p_map = place.mean.head<2>();
    view.radius_m = std::nan("");
    view.P.topLeftCorner<2, 2>() = place.P.topLeftCorner<2, 2>();
    view.existence = 1.0;
    view.sightings = beacon->sightings;
    view.confirmed = true;
    out.landmarks.push_back(view);
  }
  out.figures.push_back({"rings", static_cast<double>(rings)});
  out.figures.push_back({"scale", content_->survey.scale()});
  out.figures.push_back({"scale_sigma", std::sqrt(content_->survey.scale_variance())});
}

void BeaconMap::save(OutArchive& out) const {
  out.section("range_beacons", 1);
  out(content_->survey);
  out.value(static_cast<std::uint64_t>(content_->beacons.size()));
  for (const Cow<Beacon>& beacon : content_->beacons) out(beacon.read());
}

void BeaconMap::load(InArchive& in) {
  in.section("range_beacons", 1);
  Content content;
  in(content.survey);
  std::uint64_t count = 0;
  in.within(count, 0, 1'000'000);
  for (std::uint64_t i = 0; i < count; ++i) {
    Beacon beacon;
    in(beacon);
    const bool fits = beacon.index < content.survey.size() && (beacon.index >= 0 || !beacon.ring.places().empty());
    if (!fits) throw DataError("range_beacons: a beacon has no place in its map");
    content.beacons.emplace_back(std::move(beacon));
  }
  content_ = Cow<Content>(std::move(content));
}

}  // namespace waymark::range_beacons
