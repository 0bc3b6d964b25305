// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/particle_octomap.hpp"

#include <array>

#include "map_modules/octomap_grid/cloud_insertion.hpp"
#include "map_modules/octomap_grid/layered_field.hpp"
#include "map_modules/octomap_grid/map_view.hpp"
#include "map_modules/octomap_grid/octomap_file.hpp"
#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {

namespace {

/// Storage of one thread: a scan's marks and layers are far larger than a particle's own share of the map.
struct ThreadStorage {
  LayeredTarget target;
  CloudInsertion insertion;
};

// Not inlined: the compiler would compute the thread's address anew in the innermost loops.
[[gnu::noinline]] ThreadStorage& storage() {
  thread_local ThreadStorage own;
  return own;
}

}  // namespace

OctomapModel::OctomapModel(OctomapGridSettings s)
    : settings(std::move(s)), matcher(settings.match, settings.resolution) {
  if (settings.load.use != map_formats::MapUse::map) initial = load_octomap(settings.load.file, settings);
}

void ParticleOctomap::refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
                             Refinement& out) const {
  scan_matching::MatchAssociation& association = scan_matching::MatchAssociation::of(out);
  const auto& cloud = static_cast<const CloudObservation&>(observation);
  out.writes = writes(cloud);
  if (voxels_.empty() || cloud.matched.empty()) return;  // nothing to match: so it is for all particles

  const Eigen::Matrix3d R_map_tree = T_map_tree().q.toRotationMatrix();  // of (x, y, yaw), too: it is planar
  const PoseGaussian placed{in_tree(prior.T_map_base), R_map_tree.transpose() * prior.P * R_map_tree};
  const scan_matching::MatchPrior own = scan_matching::planar_prior(placed, in_tree(start));
  const double reach = cloud.reach + model_->matcher.margin(own);
  LayeredTarget& target = storage().target;
  target.open(voxels_, placed.T_map_base, reach, cloud.matched, model_->settings.resolution);
  association.report(model_->matcher.match(target, own), out);
  out.information = R_map_tree * out.information * R_map_tree.transpose();
  out.gradient = R_map_tree * out.gradient;
}

void ParticleOctomap::insert(const PoseGaussian& pose, const Observation& observation, const Association* association) {
  record_.count(static_cast<const scan_matching::MatchAssociation&>(*association));
  const auto& cloud = static_cast<const CloudObservation&>(observation);
  if (!writes(cloud)) return;
  storage().insertion.insert(voxels_, in_tree(pose.T_map_base), cloud, model_->settings);
}

void ParticleOctomap::correspond(const Observation& observation, const Association* /*association*/,
                                 Correspondences& out) const {
  for (const Eigen::Vector3f& hit : static_cast<const CloudObservation&>(observation).matched)
    out.points_base.emplace_back(hit.head<2>().cast<double>());
}

void ParticleOctomap::describe(MapDescription& out) const {
  const MapFigures counts = figures_of(voxels_);
  const auto number = [](auto count) { return static_cast<double>(count); };
  const std::array<const VoxelMap*, 1> own{&voxels_};
  out.figures = {{"voxels_occupied", number(counts.occupied)},
                 {"voxels_free", number(counts.free)},
                 {"mean_entropy_bit", counts.mean_entropy_bit},
                 {"nodes", number(counts.nodes)},
                 {"tiles", number(counts.tiles)},
                 {"tiles_shared", number(counts.tiles_shared)},
                 {"memory_bytes", number(VoxelMap::bytes_of(own))}};
  record_.describe(out.figures);
}

std::optional<GridView> ParticleOctomap::grid() const {
  const double up = T_map_tree().p.z();
  const Heights heights{model_->settings.slice.low - up, model_->settings.slice.high - up};
  std::optional<GridView> view = slice_of(voxels_, model_->settings.resolution, heights);
  if (view) view->T_map_grid = T_map_tree() * view->T_map_grid;
  return view;
}

std::vector<MapFile> ParticleOctomap::files(const Pose& T_enu_map) const {
  std::vector<MapFile> files = octomap_files(voxels_, model_->settings.resolution);
  for (MapFile& file : files) file.T_enu_file = T_enu_map * T_map_tree();
  return files;
}

template <class Archive>
void ParticleOctomap::serialize(Archive& archive) {
  const std::uint32_t version = archive.section("octomap_grid", 2);
  if (version < 2) throw DataError("checkpoint: octomap_grid: written by a version whose maps are not read any more");
  scan_matching::serialize_resolution(archive, model_->settings.resolution);
  archive(record_, voxels_);
}

void ParticleOctomap::save(OutArchive& out) const { out(*this); }
void ParticleOctomap::load(InArchive& in) { in(*this); }

}  // namespace waymark::octomap_grid
