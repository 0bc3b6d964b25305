// SPDX-License-Identifier: Apache-2.0
// A map module: radio beacons of unknown places, by ranges alone.
#include <string>

#include "beacon_map.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/map_module.hpp"

namespace waymark::range_beacons {
namespace {

class RangeBeacons final : public MapModule {
 public:
  RangeBeacons(const Config& config, const Rig&) {
    // The host reads `inputs` as well; the ranges are those of the first.
    const Config::Key antenna{"base_p_antenna_m", "m",
                              "lever arm: the receiver's antenna in the base frame [x, y, z], or `none`"};
    if (!config.is_list(antenna.name) && config.has(antenna.name)) {
      config.choice(antenna, {"none"});
    } else {
      settings_.p_base_antenna = Eigen::Vector3d::Map(config.numbers(antenna, 3).data());
    }
    settings_.sigma_m = config.positive({"sigma_m", "m", "noise of a range"});
    use_reported_sigma_ =
        config.boolean({"use_reported_sigma", "the device's own σ instead, where a range has one"}, false);
    settings_.scale = config.positive({"scale", "measured range per true distance, at the start"}, 1.0);
    settings_.scale_sigma =
        config.non_negative({"scale_sigma", "the scale is estimated, from this σ on; 0: it is known"}, 0.05);
    settings_.outlier_share = config.number_in(
        {"outlier_share", "share of ranges that have nothing to do with the distance"}, 0.0, 0.5, 0.01);
    settings_.range_max_m = config.positive({"range_max_m", "m", "such ranges are anywhere up to this one"}, 200.0);
    settings_.settled = config.number_in(
        {"settled_share", "a ring of places becomes one Gaussian when its σ is this share of the beacon's distance"},
        0.01, 1.0, 0.1);
  }

  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<BeaconMap>(settings_); }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow&) override {
    const auto& burst = trigger.as<Ranges>().ranges;
    if (burst.empty()) return nullptr;
    auto set = std::make_shared<RangeSet>();
    set->ranges.reserve(burst.size());
    for (const Ranges::One& one : burst) {
      if (one.reference >= 0) throw DataError("a difference of ranges; expected ranges (reference -1)");
      const bool reported = use_reported_sigma_ && one.sigma_m > 0.0;
      set->ranges.push_back({one.beacon, one.range_m, reported ? one.sigma_m : settings_.sigma_m});
    }
    return set;
  }

  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<BeaconMap>(settings_);
    map->load(in);
    return map;
  }

 private:
  Settings settings_;
  bool use_reported_sigma_ = false;
};

}  // namespace
}  // namespace waymark::range_beacons

WAYMARK_PLUGIN(waymark::MapModule, waymark::range_beacons::RangeBeacons, "range_beacons", "1.0.0")
