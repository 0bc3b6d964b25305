// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "cylinder_extraction.hpp"
#include "extraction_pictures.hpp"
#include "particle_feature_map.hpp"
#include "waymark/error.hpp"
#include "waymark/payloads.hpp"
#include "waymark/plugin.hpp"

namespace waymark {

namespace {

/// Map module 1 of Fig. 2.1: landmark extraction, data association and localisation, feature-based map.
class FeatureMap final : public MapModule {
 public:
  FeatureMap(const Config& config, const Rig& rig)
      : settings_(std::make_shared<FeatureMapSettings>(FeatureMapSettings::read(config))),
        T_base_sensor_(rig.T_base_sensor(config.texts("inputs").at(0))),
        pictures_(config.child_or_empty("extraction_pictures")) {}

  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ParticleFeatureMap>(settings_); }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow&) override {
    if (trigger.payload->type() == LandmarkObservations::kType) return ready_made(trigger.as<LandmarkObservations>());
    auto observation =
        std::make_shared<FeatureObservation>(extract_cylinders(trigger.as<LaserScan>(), T_base_sensor_, *settings_));
    pictures_.take(trigger.stamp, observation->view, settings_->extraction);
    return observation;
  }

  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<ParticleFeatureMap>(settings_);
    map->load(in);
    return map;
  }

 private:
  /// Landmarks that the device detected by itself: range is to the centre.
  std::shared_ptr<const Observation> ready_made(const LandmarkObservations& seen) const {
    auto observation = std::make_shared<FeatureObservation>();
    observation->view.p_base_sensor = T_base_sensor_.p.head<2>();
    observation->view.yaw_base_sensor = T_base_sensor_.yaw();
    DetectionNoise noise = settings_->noise;
    if (!settings_->use_radius) noise.radius = 0.0;
    for (const LandmarkObservations::One& one : seen.landmarks) {
      if (one.range_m > settings_->extraction.range_max) continue;
      const double radius = std::isfinite(one.radius_m) ? one.radius_m : 0.0;
      observation->detections.push_back(
          make_detection(one.range_m - radius, one.bearing_rad, radius, T_base_sensor_, noise));
      read_identity(one.identity, observation->detections.back());
      observation->max_range = std::max(observation->max_range, observation->detections.back().xyr.head<2>().norm());
    }
    return observation;
  }

  void read_identity(int identity, Detection& detection) const {
    detection.signature = Signature::uniform(2);
    if (settings_->identity == IdentityUse::unused) return;
    detection.identity = identity;
    if (settings_->identity != IdentityUse::signature) return;
    const auto& [bins, misreading_probability] = settings_->identity_signature;
    if (identity >= bins) {
      throw DataError("identity " + std::to_string(identity) + " has no bin of its own: signature.bins is " +
                      std::to_string(bins) + ", so identities go from 0 to " + std::to_string(bins - 1));
    }
    detection.signature = Signature::of_identity(identity, bins, misreading_probability);
  }

  std::shared_ptr<const FeatureMapSettings> settings_;
  Pose T_base_sensor_;
  ExtractionPictures pictures_;
};

}  // namespace

}  // namespace waymark

WAYMARK_PLUGIN(waymark::MapModule, waymark::FeatureMap, "feature_map", "1.0.0")
