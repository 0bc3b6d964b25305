// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "map_modules/feature_map/extraction/camera_extraction.hpp"
#include "map_modules/feature_map/extraction/extraction_counts.hpp"
#include "map_modules/feature_map/extraction/extraction_pictures.hpp"
#include "map_modules/feature_map/extraction/extraction_table.hpp"
#include "map_modules/feature_map/landmarks/landmark_file.hpp"
#include "map_modules/feature_map/particle_feature_map.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin/map_module.hpp"

namespace waymark::feature_map {

namespace {

/// Map module 1 of Fig. 2.1: landmark extraction, data association and localisation, feature-based map.
class FeatureMap final : public MapModule {
 public:
  FeatureMap(const Config& config, const Rig& rig) : FeatureMap(config, rig, camera_of(config, rig)) {}

  std::unique_ptr<ParticleMap> create_map() const override {
    return std::make_unique<ParticleFeatureMap>(settings_, initial_);
  }
  bool has_prior_map() const override { return settings_->load.use != map_formats::MapUse::map; }
  std::optional<MapFrame> prior_frame() const override { return settings_->load.frame; }

  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion> companions,
                                             const MotionWindow& motion) override {
    if (trigger.payload->type() == LandmarkObservations::kType)
      return ready_made(trigger.stamp, trigger.as<LandmarkObservations>());
    const auto& scan = trigger.as<LaserScan>();
    ScanView view = view_of(scan, T_base_sensor_, settings_->extraction, motion);
    std::vector<Candidate> candidates = examine(view, settings_->extraction);
    std::optional<ImageLook> look;
    if (camera_) {
      const Measurement* image = companions.empty() ? nullptr : companions.front().measurement;
      look = camera_->look(image, trigger.stamp, motion, T_base_sensor_, candidates);
      counts_.add(*look, candidates);
    }
    counts_.add(candidates);
    const ImageLook* seen = look ? &*look : nullptr;
    const ExtractionFrame frame{trigger.stamp, view, candidates, T_base_sensor_, seen};
    pictures_.take(frame, *settings_);
    table_.take(frame);
    FeatureObservation observation = observe(scan, std::move(view), candidates, seen, T_base_sensor_, *settings_);
    observation.stamp = trigger.stamp;
    return std::make_shared<FeatureObservation>(std::move(observation));
  }

  void describe(std::span<const ParticleMap* const>, std::vector<MapFigure>& figures) const override {
    counts_.describe(camera_.has_value(), figures);
  }
  void save(OutArchive& out) const override { out(counts_); }
  void load(InArchive& in) override { in(counts_); }

  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<ParticleFeatureMap>(settings_);
    map->load(in);
    return map;
  }

 private:
  FeatureMap(const Config& config, const Rig& rig, const std::string& camera)
      : settings_(std::make_shared<FeatureMapSettings>(FeatureMapSettings::read(config, !camera.empty()))),
        T_base_sensor_(rig.T_base_sensor(config.texts("inputs").at(0))),
        pictures_(
            config.child_or_empty({"extraction_pictures", "scans as pictures, with the verdict on every candidate"})),
        table_(config, {"extraction_table", "",
                        "CSV file, relative to the working directory: every candidate of every scan with its verdict, "
                        "place, radius and signature (columns: `extraction/extraction_table.hpp`)",
                        "none"}) {
    if (has_prior_map()) initial_ = read_landmark_file(settings_->load.file, *settings_);
    if (camera.empty()) return;
    camera_.emplace(rig.intrinsics(camera), rig.T_base_sensor(camera), *settings_->camera, settings_->noise.range);
  }

  /// Name of the second input, which must be a camera; empty if there is none.
  static std::string camera_of(const Config& config, const Rig& rig) {
    const std::vector<std::string> inputs =
        config.texts({"inputs",
                      "a scanner (`LaserScan` or `LandmarkObservations`) with `base_T_sensor`; second, at most one "
                      "camera (`payload: Image`) with `intrinsics`"});
    if (inputs.size() < 2) return {};
    const int index = rig.find(inputs[1]);
    const bool is_camera = index >= 0 && rig.mountings()[static_cast<std::size_t>(index)].payload == Image::kType;
    if (inputs.size() > 2 || !is_camera) {
      config.fail("inputs",
                  "a feature map takes a scanner and, second, at most one camera, a sensor with `payload: "
                  "Image`");
    }
    return inputs[1];
  }

  /// Landmarks that the device detected by itself: range is to the centre.
  std::shared_ptr<const Observation> ready_made(Time stamp, const LandmarkObservations& seen) const {
    auto observation = std::make_shared<FeatureObservation>();
    observation->stamp = stamp;
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
  LandmarkStore initial_;  ///< what every map begins with
  Pose T_base_sensor_;
  std::optional<CameraExtraction> camera_;
  ExtractionPictures pictures_;
  ExtractionTable table_;
  ExtractionCounts counts_;
};

}  // namespace

}  // namespace waymark::feature_map

WAYMARK_PLUGIN(waymark::MapModule, waymark::feature_map::FeatureMap, "feature_map", "1.0.0")
