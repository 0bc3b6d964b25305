// SPDX-License-Identifier: Apache-2.0
// A map module with one landmark: the charging dock, which a camera recognises.
#include "dock_map.hpp"

#include <cmath>

#include "waymark/interface/payloads.hpp"
#include "waymark/plugin.hpp"

using namespace waymark;

namespace {

class DockMapModule : public MapModule {
 public:
  DockMapModule(const Config& config, const Rig& rig)
      : sigma_m_(config.positive({"sigma_m", "m", "noise per axis of the dock in the image"})),
        T_base_camera_(rig.T_base_sensor(config.texts("inputs").front())) {}

  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<DockMap>(sigma_m_); }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow&) override {
    const auto& landmarks = trigger.as<LandmarkObservations>().landmarks;
    if (landmarks.empty()) return nullptr;  // nothing to map
    const auto& [range_m, bearing_rad, radius_m, identity] = landmarks.front();
    auto seen = std::make_shared<Seen>();
    const Eigen::Vector3d p_camera(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad), 0.0);
    seen->p_base = (T_base_camera_ * p_camera).head<2>();
    return seen;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<DockMap>(sigma_m_);
    map->load(in);
    return map;
  }

 private:
  double sigma_m_;
  Pose T_base_camera_;
};

}  // namespace

WAYMARK_PLUGIN(MapModule, DockMapModule, "dock_map", "1.0.0")
