// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "map_modules/octomap_grid/cloud_observation.hpp"
#include "map_modules/octomap_grid/particle_octomap.hpp"
#include "map_modules/shared/scan_matching/scan_spacing.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/map_module.hpp"

namespace waymark::octomap_grid {

namespace {

/// Map module 2 of Fig. 2.1: matching and localisation, dense map. Octrees, for scanners of three dimensions and for
/// planar ones that are mounted or driven at a slant.
class OctomapGrid final : public MapModule {
 public:
  OctomapGrid(const Config& config, const Rig& rig)
      : model_(std::make_shared<OctomapModel>(OctomapGridSettings::read(config))),
        T_base_sensor_(rig.T_base_sensor(scanner_of(config))) {}

  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ParticleOctomap>(model_); }

  bool is_spatial() const override { return model_->settings.is_spatial(); }
  bool has_prior_map() const override { return model_->settings.load.use != map_formats::MapUse::map; }
  std::optional<MapFrame> prior_frame() const override { return model_->settings.load.frame; }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow& motion) override {
    const bool is_cloud = trigger.payload->type() == PointCloud::kType;
    const auto* scan = is_cloud ? nullptr : &trigger.as<LaserScan>();
    if (!spacing_.is_due(trigger.stamp, motion, model_->settings.scan)) return nullptr;
    auto observation = std::make_shared<CloudObservation>(
        is_cloud ? observe(trigger.as<PointCloud>(), T_base_sensor_, motion, model_->settings)
                 : observe(*scan, T_base_sensor_, motion, model_->settings));
    observation->measures_motion = !motion.is_measured;
    spacing_.take(trigger.stamp);
    return observation;
  }

  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<ParticleOctomap>(model_);
    map->load(in);
    return map;
  }

  void describe(std::span<const ParticleMap* const> of_all_particles, std::vector<MapFigure>& out) const override {
    std::vector<const VoxelMap*> maps;
    maps.reserve(of_all_particles.size());
    for (const ParticleMap* map : of_all_particles) maps.push_back(&static_cast<const ParticleOctomap*>(map)->voxels());
    VoxelMap::describe_memory(maps, out);
  }
  void save(OutArchive& out) const override { out(spacing_); }
  void load(InArchive& in) override { in(spacing_); }

 private:
  static std::string scanner_of(const Config& config) {
    const std::vector<std::string> inputs =
        config.texts({"inputs", "one scanner (`LaserScan` or `PointCloud`), with `base_T_sensor`"});
    if (inputs.size() != 1) config.fail("inputs", "an octomap grid takes one scanner");
    return inputs.front();
  }

  std::shared_ptr<const OctomapModel> model_;
  Pose T_base_sensor_;
  scan_matching::ScanSpacing spacing_;
};

}  // namespace

}  // namespace waymark::octomap_grid

WAYMARK_PLUGIN(waymark::MapModule, waymark::octomap_grid::OctomapGrid, "octomap_grid", "1.0.0")
