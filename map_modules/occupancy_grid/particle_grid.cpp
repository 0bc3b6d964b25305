// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/particle_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "map_modules/occupancy_grid/grid_view.hpp"
#include "map_modules/occupancy_grid/map_file.hpp"
#include "map_modules/occupancy_grid/scan_insertion.hpp"
#include "waymark/base/error.hpp"

namespace waymark::occupancy_grid {

namespace {

/// Storage of one thread: a scan's marks and tiles are far larger than a particle's own share of the map.
struct ThreadScratch {
  TileWindow window;
  ScanInsertion insertion;
};

// Not inlined: the compiler would compute the thread's address anew in the innermost loops.
[[gnu::noinline]] ThreadScratch& scratch() {
  thread_local ThreadScratch own;
  return own;
}

}  // namespace

GridModel::GridModel(OccupancyGridSettings s) : settings(std::move(s)), matcher(settings.match, settings.resolution) {
  if (settings.load.use == map_formats::MapUse::map) return;
  LoadedMap loaded = load_map_file(settings.load.file, settings.odds);
  if (std::abs(loaded.resolution - settings.resolution) > 1e-9) {
    throw DataError(fmt::format("{}: its cells have {} m, but resolution_m is {}", settings.load.file.string(),
                                loaded.resolution, settings.resolution));
  }
  initial = std::move(loaded.tiles);
  T_map_grid = settings.load.T_map_file * loaded.T_map_grid;
}

void ParticleGrid::refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
                          Refinement& out) const {
  scan_matching::MatchAssociation& association = scan_matching::MatchAssociation::of(out);
  const auto& scan = static_cast<const ScanObservation&>(observation);
  out.writes =
      writes(scan) && !(scan.measures_motion && last_written_.is_near(prior.T_map_base, model_->settings.scan));
  association.writes = out.writes;
  if (tiles_.empty() || scan.hits.empty()) return;  // nothing to match: so it is for all particles

  const Eigen::Matrix3d R_map_grid = model_->T_map_grid.q.toRotationMatrix();  // of (x, y, yaw), too: it is planar
  const Pose T_grid_map = model_->T_map_grid.inverse();
  const scan_matching::MatchPrior own = scan_matching::planar_prior(
      {T_grid_map * prior.T_map_base, R_map_grid.transpose() * prior.P * R_map_grid}, T_grid_map * start);
  TileWindow& window = scratch().window;
  window.open(tiles_, own.mean.head<2>(), scan.reach + model_->matcher.margin(own), model_->settings.resolution);
  association.report(model_->matcher.match(window, scan.hits, own), R_map_grid, out);
}

void ParticleGrid::insert(const PoseGaussian& pose, const Observation& observation, const Association* association) {
  const auto* match = static_cast<const scan_matching::MatchAssociation*>(association);
  if (match != nullptr) record_.count(*match);
  const auto& scan = static_cast<const ScanObservation&>(observation);
  if (!writes(scan) || (match != nullptr && !match->writes)) return;
  last_written_.set(pose.T_map_base);
  scratch().insertion.insert(tiles_, in_grid(pose.T_map_base), scan, model_->settings);
}

std::unique_ptr<ParticleMap> ParticleGrid::blank() const {
  auto map = std::make_unique<ParticleGrid>(model_);
  map->record_ = record_;
  return map;
}

void ParticleGrid::correspond(const Observation& observation, const Association* /*association*/,
                              Correspondences& out) const {
  for (const Eigen::Vector2f& hit : static_cast<const ScanObservation&>(observation).hits)
    out.points_base.emplace_back(hit.cast<double>());
}

void ParticleGrid::describe(MapDescription& out) const {
  const GridFigures counts = figures_of(tiles_);
  const auto number = [](auto count) { return static_cast<double>(count); };
  const std::array<const TileTree*, 1> own{&tiles_};
  out.figures = {{"cells_occupied", number(counts.occupied)},   {"cells_free", number(counts.free)},
                 {"mean_entropy_bit", counts.mean_entropy_bit}, {"tiles", number(counts.tiles)},
                 {"tiles_shared", number(counts.tiles_shared)}, {"memory_bytes", number(TileTree::bytes_of(own))}};
  record_.describe(out.figures);
}

std::optional<GridView> ParticleGrid::grid() const {
  std::optional<GridView> view = view_of(tiles_, model_->settings.resolution);
  if (view) view->T_map_grid = model_->T_map_grid * view->T_map_grid;
  return view;
}

template <class Archive>
void ParticleGrid::serialize(Archive& archive) {
  if (archive.section("occupancy_grid", 5) < 5) throw DataError("the checkpoint has an older version");
  scan_matching::serialize_resolution(archive, model_->settings.resolution);
  archive(record_, tiles_, last_written_);
}

void ParticleGrid::save(OutArchive& out) const { out(*this); }
void ParticleGrid::load(InArchive& in) { in(*this); }

}  // namespace waymark::occupancy_grid
