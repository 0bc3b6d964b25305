// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/feature_map_settings.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "map_modules/feature_map/signature.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::feature_map {

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

ExtractionSettings read_extraction(const Config& config) {
  ExtractionSettings s;
  s.range_min = config.non_negative("range_min_m", 0.1);
  s.range_max = config.positive("range_max_m", 30.0);
  s.no_return = config.positive("no_return_m", 80.0);
  s.segment_jump = config.positive("segment_jump_m", 0.5);
  s.background = config.positive("background_m", 1.0);
  s.width_max = config.positive("width_max_m", 1.2);
  s.isolation = config.non_negative("isolation_m", 0.0);
  s.min_beams = static_cast<int>(config.integer_in("min_beams", 1, 10000, 1));
  s.bright_above = config.has("bright_above") ? config.number("bright_above") : std::numeric_limits<double>::infinity();
  if (s.range_max <= s.range_min) config.fail("range_max_m", "must exceed range_min_m");
  return s;
}

CameraSettings read_camera(const Config& config) {
  CameraSettings s;
  constexpr auto kMost = static_cast<std::int64_t>(Signature::kMaxBins);
  s.hue_bins = static_cast<int>(config.integer_in("hue_bins", 1, kMost, 16));
  s.saturation_bins = static_cast<int>(config.integer_in("saturation_bins", 1, kMost, 4));
  if (s.hue_bins * s.saturation_bins > kMost) {
    config.fail("hue_bins", "hue_bins times saturation_bins must be at most " + std::to_string(kMost) + ", not " +
                                std::to_string(s.hue_bins * s.saturation_bins));
  }
  s.value_min = config.number_in("value_min", 0.0, 1.0, 0.15);
  s.edge_min_contrast = config.number_in("edge_min_contrast", 1.0, 255.0, 12.0);
  s.edge_min_cover = config.number_in("edge_min_cover", 0.0, 1.0, 0.75);
  s.edge_below = config.non_negative("edge_below_m", 0.3);
  s.edge_above = config.positive("edge_above_m", 0.3);
  s.edge_search = kRadPerDeg * config.number_in("edge_search_deg", 0.05, 20.0, 1.5);
  s.edge_sigma_px = config.positive("edge_sigma_px", 1.0);
  s.width_ratio_min = config.number_in("width_ratio_min", 0.0, 1.0, 0.5);
  s.width_ratio_max = config.number_in("width_ratio_max", 1.0, 100.0, 2.0);
  const std::string unseen = config.choice("unseen", {"keep", "match", "drop"}, "match");
  s.unseen = unseen == "keep" ? Unseen::keep : unseen == "match" ? Unseen::match : Unseen::drop;
  return s;
}

DetectionNoise read_noise(const Config& config) {
  return {config.positive("range_m", 0.05), kRadPerDeg * config.positive("bearing_deg", 0.35),
          config.non_negative("tangential_m", 0.05), config.positive("radius_m", 0.1)};
}

AssociationMethod read_method(const Config& config) {
  return config.choice("method", {"greedy", "optimal"}, "greedy") == "optimal" ? AssociationMethod::optimal
                                                                               : AssociationMethod::greedy;
}

AssociationSettings read_association(const Config& config, int dimension, const std::optional<CameraSettings>& camera) {
  AssociationSettings s;
  s.method = read_method(config);
  s.gate = gaussian::chi_squared_quantile(config.number_in("gate_probability", 0.5, 1.0 - 1e-9, 0.99), dimension);
  s.identity_gate = gaussian::chi_squared_quantile(
      config.number_in("identity_gate_probability", 0.5, 1.0 - 1e-9, 0.999996), dimension);
  s.new_landmark_density = config.positive("new_landmark_density_per_m2", 0.01);
  s.detection_probability = config.number_in("detection_probability", 0.01, 0.999, 0.9);
  s.log_min_likelihood_ratio = std::log(config.number_in("min_likelihood_ratio", 1.0, 1e9, 1.0));
  s.min_separation = config.non_negative("min_separation_m", 0.5);
  s.merge = config.boolean("merge", false);
  s.radius_range = config.positive("radius_range_m", 1.0);
  s.signature_lambda = config.non_negative("signature_lambda", 20.0);
  s.signature_fusion = config.choice("signature_fusion", {"product", "dirichlet"}, "product") == "dirichlet"
                           ? SignatureFusion::dirichlet
                           : SignatureFusion::product;
  s.signature_floor = config.number_in("signature_floor", 1e-9, 0.4, camera ? 0.001 : 0.01);
  if (camera && s.signature_floor * camera->hue_bins * camera->saturation_bins >= 0.5)
    config.fail("signature_floor", "must lie well below one over the number of bins, hue_bins times saturation_bins");
  s.new_landmark_signature_distance = config.has("new_landmark_signature_distance")
                                          ? config.number_in("new_landmark_signature_distance", 0.0, 1.0)
                                          : std::numeric_limits<double>::quiet_NaN();
  return s;
}

IdentityUse read_identity(const Config& config) {
  const std::string word = config.choice("identity", {"unused", "signature", "known"}, "unused");
  return word == "known" ? IdentityUse::known : word == "signature" ? IdentityUse::signature : IdentityUse::unused;
}

IdentitySignature read_identity_signature(const Config& config) {
  IdentitySignature s;
  s.bins = static_cast<int>(config.integer_in("bins", 2, static_cast<std::int64_t>(Signature::kMaxBins), 100));
  s.misreading_probability = config.number_in("misreading_probability", 1e-6, 0.5, 0.01);
  return s;
}

ExistenceSettings read_existence(const Config& config) {
  ExistenceSettings s;
  s.min_observations = static_cast<int>(config.integer_in("min_observations", 1, 1000, 3));
  s.log_odds_hit = config.positive("log_odds_hit", 0.7);
  s.log_odds_miss = config.number_in("log_odds_miss", -100.0, 0.0, -0.4);
  s.log_odds_max = config.positive("log_odds_max", 5.0);
  s.delete_below = config.number("delete_below", -2.0);
  s.delete_provisional_below = config.number("delete_provisional_below", -0.9);
  s.view_range = config.positive("view_range_m", 25.0);
  s.view_half_angle = kRadPerDeg * config.number_in("view_half_angle_deg", 0.0, 180.0, 86.0);
  s.free_margin = config.positive("free_margin_m", 1.0);
  s.max_misses = static_cast<int>(config.integer_in("max_misses", 0, 1000, 3));
  return s;
}

}  // namespace

FeatureMapSettings FeatureMapSettings::read(const Config& config, bool with_camera) {
  FeatureMapSettings s;
  for (const std::string& attribute : config.texts("attributes", std::vector<std::string>{})) {
    if (attribute == "radius") {
      s.use_radius = true;
    } else if (attribute == "signature") {
      s.use_signature = true;
    } else {
      config.fail("attributes", "\"" + attribute + "\" is not an attribute; possible are radius, signature");
    }
  }
  s.use_negative_information = config.boolean("negative_information", true);
  s.keep_sightings = config.boolean("keep_sightings", false);
  s.identity = read_identity(config);
  s.identity_signature = read_identity_signature(config.child_or_empty("signature"));
  if (s.identity == IdentityUse::signature) s.use_signature = true;
  s.extraction = read_extraction(config.child_or_empty("extraction"));
  if (with_camera) {
    s.camera = read_camera(config.child_or_empty("camera"));
    if (s.identity != IdentityUse::unused) config.fail("identity", "must be unused with a camera: scans read none");
  } else if (config.has("camera")) {
    config.fail("camera", "none of the inputs is a camera, a sensor with `payload: Image`");
  }
  s.noise = read_noise(config.child_or_empty("noise"));
  s.association = read_association(config.child_or_empty("association"), s.use_radius ? 3 : 2, s.camera);
  s.existence = read_existence(config.child_or_empty("existence"));
  s.load = map_formats::LoadSettings::read(config);
  return s;
}

std::size_t FeatureMapSettings::signature_bins() const {
  if (!use_signature) return 0;
  if (camera) return static_cast<std::size_t>(camera->hue_bins) * static_cast<std::size_t>(camera->saturation_bins);
  constexpr std::size_t kReflectivityBins = 2;  // dark, bright
  return identity == IdentityUse::signature ? static_cast<std::size_t>(identity_signature.bins) : kReflectivityBins;
}

}  // namespace waymark::feature_map
