// SPDX-License-Identifier: Apache-2.0
#include "fusion/snapshot_view.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <utility>

#include "fusion/landmark_marginals.hpp"
#include "particles/grid_mixture.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::fusion {

std::vector<ParticleView> SnapshotView::particles() const {
  std::vector<ParticleView> views;
  filter_.view(views);
  return views;
}

std::vector<StampedPose> SnapshotView::best_path() const {
  std::vector<StampedPose> path = best().path.poses();
  if (filter_.georeference()) {
    const Pose T_enu_map = filter_.T_enu_map(best());
    for (StampedPose& node : path) node.T_map_base = T_enu_map * node.T_map_base;
  }
  return path;
}

std::vector<MapDescription> SnapshotView::best_maps(MapDetail detail) const {
  std::vector<MapDescription> result;
  std::vector<const ParticleMap*> of_all;
  of_all.reserve(filter_.particles().size());
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    const auto& map = filter_.whole_maps(best())[i];
    if (!map) continue;
    MapDescription& description = result.emplace_back();
    description.module = maps_[i].name;
    map->describe(description);
    if (maps_[i].module) {
      of_all.clear();
      for (const particles::Particle& particle : filter_.particles())
        of_all.push_back(filter_.whole_maps(particle)[i].get());
      maps_[i].module->describe(of_all, description.figures);
    }
    if (detail == MapDetail::with_grids || detail == MapDetail::with_mixtures) description.grid = map->grid();
    if (detail == MapDetail::with_mixtures) description.mixture = mixture_of(i, description.grid);
    if (detail == MapDetail::with_files) description.files = map->files(filter_.T_enu_map(best()));
    make_marginal(description);
  }
  return result;
}

std::optional<GridView> SnapshotView::mixture_of(std::size_t map, const std::optional<GridView>& of_best) const {
  std::vector<particles::WeightedGrid> grids;
  grids.reserve(filter_.particles().size());
  const particles::Particle& best_particle = best();
  for (const particles::Particle& particle : filter_.particles()) {
    const auto& own = filter_.whole_maps(particle)[map];
    if (!own) continue;
    if (auto grid = &particle == &best_particle ? of_best : own->grid())
      grids.push_back({std::move(*grid), std::exp(particle.log_weight)});
  }
  return particles::mix_grids(grids);
}

/// A map has landmarks given its particle's path; the report has the marginal ones of the joint Gaussian.
void SnapshotView::make_marginal(MapDescription& map) const {
  std::vector<std::optional<joint::JointBelief::LandmarkEstimate>> marginal;
  std::vector<Eigen::Matrix2d> own;
  marginal.reserve(map.landmarks.size());
  own.reserve(map.landmarks.size());
  const bool is_on_earth = filter_.georeference().has_value();
  const Eigen::Rotation2Dd turn(is_on_earth ? filter_.T_enu_map(best()).yaw() : 0.0);
  for (const LandmarkView& landmark : map.landmarks) {
    marginal.push_back(filter_.landmark(landmark.birth));
    own.emplace_back(turn * landmark.P.topLeftCorner<2, 2>() * turn.inverse());
  }
  if (is_on_earth) place_on_earth(map);
  report_marginals(map.landmarks, marginal, own);
}

/// Transforms landmarks and grids from the map to ENU. The landmarks' covariances then include that of the map's place
/// on the Earth.
void SnapshotView::place_on_earth(MapDescription& map) const {
  const estimation::Georeference& georeference = *filter_.georeference();
  const Pose T_enu_map = filter_.T_enu_map(best());
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_enu_map.q.toRotationMatrix().topLeftCorner<2, 2>();
  if (map.grid) map.grid->T_map_grid = T_enu_map * map.grid->T_map_grid;
  if (map.mixture) map.mixture->T_map_grid = T_enu_map * map.mixture->T_map_grid;
  for (LandmarkView& landmark : map.landmarks) {
    landmark.P = turn * landmark.P * turn.transpose();
    landmark.P.topLeftCorner<2, 2>() += georeference.point_covariance(best().belief, landmark.p_map);
    landmark.p_map = (T_enu_map * Eigen::Vector3d(landmark.p_map.x(), landmark.p_map.y(), 0.0)).head<2>();
  }
}

}  // namespace waymark::fusion
