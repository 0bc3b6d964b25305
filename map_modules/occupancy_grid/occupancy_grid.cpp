// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "particle_grid.hpp"
#include "scan_observation.hpp"
#include "scan_spacing.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/map_module.hpp"

namespace waymark {

namespace {

/// Map module 2 of Fig. 2.1: matching and localisation, dense map. A flat grid for planar scanners.
class OccupancyGrid final : public MapModule {
 public:
  OccupancyGrid(const Config& config, const Rig& rig)
      : model_(std::make_shared<grid::GridModel>(grid::OccupancyGridSettings::read(config))),
        T_base_sensor_(rig.T_base_sensor(scanner_of(config))) {}

  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<grid::ParticleGrid>(model_); }

  bool begins_with_a_place() const override { return model_->settings.use != grid::MapUse::map; }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow& motion) override {
    const auto& scan = trigger.as<LaserScan>();
    if (!spacing_.is_due(trigger.stamp, motion, model_->settings.scan)) return nullptr;
    auto observation =
        std::make_shared<grid::ScanObservation>(grid::observe(scan, T_base_sensor_, motion, model_->settings.scan));
    spacing_.take(trigger.stamp);
    return observation;
  }

  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<grid::ParticleGrid>(model_);
    map->load(in);
    return map;
  }

  void describe(std::span<const ParticleMap* const> of_all_particles, std::vector<MapFigure>& out) const override {
    std::vector<const grid::TileTree*> trees;
    trees.reserve(of_all_particles.size());
    for (const ParticleMap* map : of_all_particles)
      trees.push_back(&static_cast<const grid::ParticleGrid*>(map)->tiles());
    grid::TileTree::describe_memory(trees, out);
  }
  void save(OutArchive& out) const override { spacing_.save(out); }
  void load(InArchive& in) override { spacing_.load(in); }

 private:
  static std::string scanner_of(const Config& config) {
    const std::vector<std::string> inputs = config.texts("inputs");
    if (inputs.size() != 1) config.fail("inputs", "an occupancy grid takes one scanner");
    return inputs.front();
  }

  std::shared_ptr<const grid::GridModel> model_;
  Pose T_base_sensor_;
  grid::ScanSpacing spacing_;
};

}  // namespace

}  // namespace waymark

WAYMARK_PLUGIN(waymark::MapModule, waymark::OccupancyGrid, "occupancy_grid", "1.0.0")
