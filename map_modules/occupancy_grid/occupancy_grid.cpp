// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "map_modules/occupancy_grid/particle_grid.hpp"
#include "map_modules/occupancy_grid/scan_observation.hpp"
#include "map_modules/shared/scan_matching/scan_spacing.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/map_module.hpp"

namespace waymark::occupancy_grid {

namespace {

/// Map module 2 of Fig. 2.1: matching and localisation, dense map. A flat grid for planar scanners.
class OccupancyGrid final : public MapModule {
 public:
  OccupancyGrid(const Config& config, const Rig& rig)
      : model_(std::make_shared<GridModel>(OccupancyGridSettings::read(config))),
        T_base_sensor_(rig.T_base_sensor(scanner_of(config))) {}

  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ParticleGrid>(model_); }

  bool has_prior_map() const override { return model_->settings.load.use != map_formats::MapUse::map; }
  std::optional<MapFrame> prior_frame() const override { return model_->settings.load.frame; }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow& motion) override {
    const auto& scan = trigger.as<LaserScan>();
    if (!spacing_.is_due(trigger.stamp, motion, model_->settings.scan)) return nullptr;
    auto observation = std::make_shared<ScanObservation>(observe(scan, T_base_sensor_, motion, model_->settings.scan));
    observation->measures_motion = !motion.is_measured;
    spacing_.take(trigger.stamp);
    return observation;
  }

  bool can_draw_again() const override { return true; }
  void save_observation(const Observation& observation, OutArchive& out) const override {
    out(static_cast<const ScanObservation&>(observation));
  }
  std::shared_ptr<const Observation> load_observation(InArchive& in) const override {
    auto observation = std::make_shared<ScanObservation>();
    in(*observation);
    return observation;
  }

  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<ParticleGrid>(model_);
    map->load(in);
    return map;
  }

  void describe(std::span<const ParticleMap* const> of_all_particles, std::vector<MapFigure>& out) const override {
    std::vector<const TileTree*> trees;
    trees.reserve(of_all_particles.size());
    for (const ParticleMap* map : of_all_particles) trees.push_back(&static_cast<const ParticleGrid*>(map)->tiles());
    TileTree::describe_memory(trees, out);
  }
  void save(OutArchive& out) const override { out(spacing_); }
  void load(InArchive& in) override { in(spacing_); }

 private:
  static std::string scanner_of(const Config& config) {
    const std::vector<std::string> inputs = config.texts({"inputs", "one scanner (`LaserScan`), with `base_T_sensor`"});
    if (inputs.size() != 1) config.fail("inputs", "an occupancy grid takes one scanner");
    return inputs.front();
  }

  std::shared_ptr<const GridModel> model_;
  Pose T_base_sensor_;
  scan_matching::ScanSpacing spacing_;
};

}  // namespace

}  // namespace waymark::occupancy_grid

WAYMARK_PLUGIN(waymark::MapModule, waymark::occupancy_grid::OccupancyGrid, "occupancy_grid", "1.0.0")
