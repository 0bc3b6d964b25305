// SPDX-License-Identifier: Apache-2.0
// A map module: a grid of the radars' targets that stand still.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "hit_grid.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin.hpp"

namespace waymark::radar_map {
namespace {

class RadarMap final : public MapModule {
 public:
  RadarMap(const Config& config, const Rig& rig)
      : resolution_m_(config.positive({"resolution_m", "m", "side of a cell"}, 0.2)),
        hit_(config.number_in({"hit", "probability that a target shows something that stands in its cell"}, 0.001,
                              0.999, 0.2)),
        range_min_m_(config.non_negative({"range_min_m", "m", "nearer targets are not used"}, 1.0)),
        range_max_m_(
            config.positive({"range_max_m", "m", "targets further away are not used: angles are coarse"}, 40.0)),
        still_mps_(config.positive(
            {"still_mps", "m/s", "a target whose radial velocity differs more from the robot's own moves by itself"},
            0.5)) {
    for (const std::string& input : config.texts("inputs")) inputs_.push_back({input, rig.T_base_sensor(input)});
  }

  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<HitGrid>(resolution_m_, hit_); }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<HitGrid>(resolution_m_, hit_);
    map->load(in);
    return map;
  }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion> companions,
                                             const MotionWindow& motion) override {
    auto still = std::make_shared<StillTargets>();
    add(trigger.as<RadarTargets>(), inputs_.front().T_base_sensor, {}, motion, *still);
    for (const Companion& companion : companions) {
      if (companion.measurement == nullptr) continue;
      for (const Input& input : inputs_) {
        if (input.sensor != companion.input) continue;
        const Pose moved = motion.relative(to_seconds(companion.measurement->stamp - trigger.stamp));
        add(companion.measurement->as<RadarTargets>(), input.T_base_sensor, moved, motion, *still);
      }
    }
    return still->points_base.empty() ? nullptr : still;
  }

 private:
  struct Input {
    std::string sensor;
    Pose T_base_sensor;
  };

  /// Those targets that stand still; `T_now_then`: the base at the scan, seen from that at the trigger.
  void add(const RadarTargets& scan, const Pose& T_base_sensor, const Pose& T_now_then, const MotionWindow& motion,
           StillTargets& still) const {
    if (const std::string problem = scan.problem(); !problem.empty()) throw DataError(problem);
    const Eigen::Vector3d v = motion.v_base + motion.w_base.cross(T_base_sensor.p);
    for (const RadarTargets::One& one : scan.targets) {
      if (one.range_m < range_min_m_ || one.range_m > range_max_m_) continue;
      const double across = std::cos(one.elevation_rad);
      const Eigen::Vector3d ray =
          T_base_sensor.q * Eigen::Vector3d(across * std::cos(one.azimuth_rad), across * std::sin(one.azimuth_rad),
                                            std::sin(one.elevation_rad));
      if (std::abs(one.radial_mps + ray.dot(v)) > still_mps_) continue;
      still.points_base.emplace_back((T_now_then * (T_base_sensor.p + one.range_m * ray)).head<2>());
    }
  }

  double resolution_m_;
  double hit_;
  double range_min_m_;
  double range_max_m_;
  double still_mps_;
  std::vector<Input> inputs_;
};

}  // namespace
}  // namespace waymark::radar_map

WAYMARK_PLUGIN(waymark::MapModule, waymark::radar_map::RadarMap, "radar_map", "1.0.0")
