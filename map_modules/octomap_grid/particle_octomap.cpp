// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/particle_octomap.hpp"

#include <array>

#include "map_modules/octomap_grid/cloud_insertion.hpp"
#include "map_modules/octomap_grid/layered_field.hpp"
#include "map_modules/octomap_grid/map_view.hpp"
#include "map_modules/octomap_grid/octomap_file.hpp"
#include "map_modules/octomap_grid/surfels/surfel_matcher.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::octomap_grid {

namespace {

/// Storage of one thread: a scan's marks and layers are far larger than a particle's own share of the map.
struct ThreadStorage {
  LayeredTarget target;
  CloudInsertion insertion;
  SurfelMatcher surfel_matcher;
  SurfelAddition surfel_addition;
};

// Not inlined: the compiler would compute the thread's address anew in the innermost loops.
[[gnu::noinline]] ThreadStorage& storage() {
  thread_local ThreadStorage own;
  return own;
}

}  // namespace

namespace {

constexpr std::array<int, 3> kPlanar{0, 1, 5};  // x, y and yaw among the six of a pose

/// Where a match moves x, y and yaw alone, height, roll and pitch are certain.
SpatialMatrix covariance_of(const PoseGaussian& pose, bool is_spatial) {
  if (is_spatial && pose.P_spatial) return *pose.P_spatial;
  SpatialMatrix P = SpatialMatrix::Zero();
  P(kPlanar, kPlanar) = pose.P;
  return P;
}

/// The middles of occupied voxels. A leaf of more voxels is a solid block without a surface.
std::vector<Eigen::Vector3f> surface_of(const VoxelMap& map, double resolution) {
  std::vector<Eigen::Vector3f> points;
  for_all_leaves(map, [&](const Voxel& voxel, int side, float odds) {
    if (side > 1 || odds <= 0.0f) return;
    const Eigen::Vector3d middle = (Eigen::Vector3d(voxel.x, voxel.y, voxel.z).array() + 0.5) * resolution;
    points.emplace_back(middle.cast<float>());
  });
  return points;
}

}  // namespace

OctomapModel::OctomapModel(OctomapGridSettings s)
    : settings(std::move(s)), matcher(settings.match, settings.resolution) {
  if (settings.load.use == map_formats::MapUse::map) return;
  initial = load_octomap(settings.load.file, settings);
  if (settings.has_surfels())
    initial_surfels.add(surface_of(initial, settings.resolution), Pose{}, settings.surfel_cell,
                        storage().surfel_addition);
}

void ParticleOctomap::refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
                             Refinement& out) const {
  scan_matching::MatchAssociation& association = scan_matching::MatchAssociation::of(out);
  const auto& cloud = static_cast<const CloudObservation&>(observation);
  // Where planes are matched in space the height is lost sooner if fewer clouds are written.
  const bool may_leave_out = cloud.measures_motion && !model_->settings.has_surfels();
  out.writes = writes(cloud) && !(may_leave_out && last_written_.is_near(prior.T_map_base, model_->settings.scan));
  association.writes = out.writes;
  if (voxels_.empty() || cloud.matched.empty()) return;  // nothing to match: so it is for all particles
  if (model_->settings.has_surfels()) {
    refine_on_planes(prior, start, cloud, association, out);
    return;
  }

  const Eigen::Matrix3d R_map_tree = T_map_tree().q.toRotationMatrix();  // of (x, y, yaw), too: it is planar
  const PoseGaussian placed{in_tree(prior.T_map_base), R_map_tree.transpose() * prior.P * R_map_tree};
  const scan_matching::MatchPrior own = scan_matching::planar_prior(placed, in_tree(start));
  const double reach = cloud.reach + model_->matcher.margin(own);
  LayeredTarget& target = storage().target;
  target.open(voxels_, placed.T_map_base, reach, cloud.matched, model_->settings.resolution);
  association.report(model_->matcher.match(target, own), R_map_tree, out);
}

void ParticleOctomap::refine_on_planes(const PoseGaussian& prior, const Pose& start, const CloudObservation& cloud,
                                       scan_matching::MatchAssociation& association, Refinement& out) const {
  // Of positions and turns, both about the map's axes.
  SpatialMatrix R_map_tree = SpatialMatrix::Zero();
  R_map_tree.topLeftCorner<3, 3>() = R_map_tree.bottomRightCorner<3, 3>() = T_map_tree().q.toRotationMatrix();
  const Pose mean = in_tree(prior.T_map_base);
  const Pose begin = in_tree(start);
  SpatialVector to_start;
  to_start << begin.p - mean.p, so3::log(begin.q * mean.q.conjugate());
  const OctomapGridSettings& settings = model_->settings;
  const SpatialPrior own{mean, R_map_tree.transpose() * covariance_of(prior, settings.is_spatial()) * R_map_tree,
                         to_start};
  const SpatialMatch match =
      storage().surfel_matcher.match(surfels_, settings.surfel_cell, cloud.matched, cloud.reach, own, settings.match);
  scan_matching::Match planar;
  planar.log_evidence = match.log_evidence;
  planar.score = match.score;
  planar.searched = match.searched;
  planar.misfits = match.searched;
  planar.failed = match.failed;
  if (!match.failed) {
    const SpatialInformation all{R_map_tree * match.information * R_map_tree.transpose(), R_map_tree * match.gradient};
    if (settings.is_spatial()) {
      const SpatialInformation::Marginal marginal = all.planar();
      planar.information = marginal.information;
      planar.gradient = marginal.gradient;
      out.spatial = all;
    } else {
      planar.information = all.information(kPlanar, kPlanar);
      planar.gradient = all.gradient(kPlanar);
    }
  }
  association.report({planar}, Eigen::Matrix3d::Identity(), out);
}

void ParticleOctomap::insert(const PoseGaussian& pose, const Observation& observation, const Association* association) {
  const auto& match = static_cast<const scan_matching::MatchAssociation&>(*association);
  record_.count(match);
  const auto& cloud = static_cast<const CloudObservation&>(observation);
  if (!writes(cloud) || !match.writes) return;
  last_written_.set(pose.T_map_base);
  const OctomapGridSettings& settings = model_->settings;
  const Pose T_tree_base = in_tree(pose.T_map_base);
  storage().insertion.insert(voxels_, T_tree_base, cloud, settings);
  if (settings.has_surfels()) surfels_.add(cloud.hits, T_tree_base, settings.surfel_cell, storage().surfel_addition);
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
  if (model_->settings.has_surfels()) surfels_.describe(out.figures);
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
  const std::uint32_t version = archive.section("octomap_grid", 5);
  if (version < 5) throw DataError("checkpoint: octomap_grid: written by a version whose maps are not read any more");
  scan_matching::serialize_resolution(archive, model_->settings.resolution);
  archive(record_, voxels_, surfels_, last_written_);
}

void ParticleOctomap::save(OutArchive& out) const { out(*this); }
void ParticleOctomap::load(InArchive& in) { in(*this); }

}  // namespace waymark::octomap_grid
