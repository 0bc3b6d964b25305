// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/feature_map_settings.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "map_modules/feature_map/signature.hpp"
#include "plugins/shared/map_formats/map_manifest.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::feature_map {

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

ExtractionSettings read_extraction(const Config& config) {
  ExtractionSettings s;
  s.range_min = config.non_negative({"range_min_m", "m", "nearer returns are the robot itself"}, 0.1);
  s.range_max = config.positive({"range_max_m", "m", "farther returns make no candidate"}, 30.0);
  s.no_return = config.positive({"no_return_m", "m", "readings at or above this mean that nothing came back"}, 80.0);
  s.segment_jump =
      config.positive({"segment_jump_m", "m", "neighbouring beams that differ by more belong to two things"}, 0.5);
  s.background =
      config.positive({"background_m", "m", "the surroundings must be this much farther on both sides"}, 1.0);
  s.width_max = config.positive({"width_max_m", "m", "wider things are not a trunk or pillar"}, 1.2);
  s.isolation = config.non_negative({"isolation_m", "m", "no other return this near the centre; 0: off"}, 0.0);
  s.min_beams = static_cast<int>(config.integer_in({"min_beams", "fewer beams make no candidate"}, 1, 10000, 1));
  s.bright_above = config.has("bright_above")
                       ? config.number({"bright_above", "", "intensity above which a segment is bright", "none"})
                       : std::numeric_limits<double>::infinity();
  if (s.range_max <= s.range_min) config.fail("range_max_m", "must exceed range_min_m");
  return s;
}

CameraSettings read_camera(const Config& config) {
  CameraSettings s;
  constexpr auto kMost = static_cast<std::int64_t>(Signature::kMaxBins);
  s.hue_bins = static_cast<int>(
      config.integer_in({"hue_bins", "bins of the hue; times `saturation_bins` at most 128"}, 1, kMost, 16));
  s.saturation_bins = static_cast<int>(config.integer_in({"saturation_bins", "bins of the saturation"}, 1, kMost, 4));
  if (s.hue_bins * s.saturation_bins > kMost) {
    config.fail("hue_bins", "hue_bins times saturation_bins must be at most " + std::to_string(kMost) + ", not " +
                                std::to_string(s.hue_bins * s.saturation_bins));
  }
  s.value_min = config.number_in({"value_min", "darker pixels (0 to 1) have no colour"}, 0.0, 1.0, 0.15);
  s.edge_min_contrast =
      config.number_in({"edge_min_contrast", "grey levels", "least contrast of an edge, of 255"}, 1.0, 255.0, 12.0);
  s.edge_min_cover = config.number_in({"edge_min_cover", "share of the rows on which an edge must have that contrast"},
                                      0.0, 1.0, 0.75);
  s.edge_below = config.non_negative(
      {"edge_below_m", "m", "rows used, down to this far below the scan; not below the ground"}, 0.3);
  s.edge_above = config.positive({"edge_above_m", "m", "rows used, up to this far above the scan"}, 0.3);
  s.edge_search =
      kRadPerDeg * config.number_in({"edge_search_deg", "°", "search about each predicted border"}, 0.05, 20.0, 1.5);
  s.edge_sigma_px = config.positive({"edge_sigma_px", "px", "σ of one edge"}, 1.0);
  s.width_ratio_min =
      config.number_in({"width_ratio_min", "least ratio of the width in the image to that in the scan"}, 0.0, 1.0, 0.5);
  s.width_ratio_max = config.number_in(
      {"width_ratio_max", "largest ratio of the width in the image to that in the scan"}, 1.0, 100.0, 2.0);
  const std::string unseen = config.choice({"unseen",
                                            "candidates without a usable image: `keep`: as good as any other; `match`: "
                                            "may be a landmark of the map, but make no new one; `drop`: left out"},
                                           {"keep", "match", "drop"}, "match");
  s.unseen = unseen == "keep" ? Unseen::keep : unseen == "match" ? Unseen::match : Unseen::drop;
  return s;
}

DetectionNoise read_noise(const Config& config) {
  return {config.positive({"range_m", "m", "σ of the range"}, 0.05),
          kRadPerDeg * config.positive({"bearing_deg", "°", "σ of the bearing"}, 0.35),
          config.non_negative({"tangential_m", "m", "σ across the beam: where on the cylinder the beams hit"}, 0.05),
          config.positive({"radius_m", "m", "σ of the radius"}, 0.1),
          config.number_in({"range_share", "σ of the range that grows with it, as a share, beside `range_m`"}, 0.0, 1.0,
                           0.0),
          config.non_negative(
              {"correlation_s", "s",
               "time constant of a detection's errors, for the covariance that is reported: what is seen again "
               "sooner has the same ones; 0: independent"},
              0.0)};
}

AssociationMethod read_method(const Config& config) {
  return config.choice({"method", "`greedy`: the likeliest pair first; `optimal`: the greatest sum of log likelihoods"},
                       {"greedy", "optimal"}, "greedy") == "optimal"
             ? AssociationMethod::optimal
             : AssociationMethod::greedy;
}

AssociationSettings read_association(const Config& config, int dimension, const std::optional<CameraSettings>& camera) {
  AssociationSettings s;
  s.method = read_method(config);
  s.gate = gaussian::chi_squared_quantile(
      config.number_in({"gate_probability", "χ² gate of a pair"}, 0.5, 1.0 - 1e-9, 0.99), dimension);
  s.identity_gate = gaussian::chi_squared_quantile(
      config.number_in({"identity_gate_probability", "χ² gate of a known identity; 0.999996: 25 for two dimensions"},
                       0.5, 1.0 - 1e-9, 0.999996),
      dimension);
  s.new_landmark_density =
      config.positive({"new_landmark_density_per_m2", "1/m²", "ρ_new: density of new landmarks"}, 0.01);
  s.detection_probability = config.number_in(
      {"detection_probability", "P_D: probability that a landmark in view is detected"}, 0.01, 0.999, 0.9);
  s.log_min_likelihood_ratio = std::log(config.number_in(
      {"min_likelihood_ratio", "a match must be this much likelier than with any other landmark"}, 1.0, 1e9, 1.0));
  s.min_separation = config.non_negative({"min_separation_m", "m", "least distance between landmarks"}, 0.5);
  s.merge = config.boolean({"merge", "merge landmarks that have come closer than `min_separation_m` and agree"}, false);
  s.radius_range = config.positive({"radius_range_m", "m", "r_max − r_min: span of the radii of new landmarks"}, 1.0);
  s.signature_lambda = config.non_negative({"signature_lambda", "λ of (4.7)"}, 20.0);
  s.signature_fusion =
      config.choice({"signature_fusion", "`product`: (4.10); `dirichlet`: the running mean of the views"},
                    {"product", "dirichlet"}, "product") == "dirichlet"
          ? SignatureFusion::dirichlet
          : SignatureFusion::product;
  s.signature_floor =
      config.number_in({"signature_floor", "", "floor of a bin of the product", "0.01; with a camera 0.001"}, 1e-9, 0.4,
                       camera ? 0.001 : 0.01);
  if (camera && s.signature_floor * camera->hue_bins * camera->saturation_bins >= 0.5)
    config.fail("signature_floor", "must lie well below one over the number of bins, hue_bins times saturation_bins");
  s.new_landmark_signature_distance =
      config.has("new_landmark_signature_distance")
          ? config.number_in({"new_landmark_signature_distance", "", "D of a new landmark in p₀", "learnt"}, 0.0, 1.0)
          : std::numeric_limits<double>::quiet_NaN();
  return s;
}

IdentityUse read_identity(const Config& config) {
  const std::string word = config.choice({"identity",
                                          "use of an identity that the device reads: `unused`; `signature`: a "
                                          "signature with one bin for each; `known`: it decides the association"},
                                         {"unused", "signature", "known"}, "unused");
  return word == "known" ? IdentityUse::known : word == "signature" ? IdentityUse::signature : IdentityUse::unused;
}

IdentitySignature read_identity_signature(const Config& config) {
  IdentitySignature s;
  s.bins = static_cast<int>(config.integer_in({"bins", "of `identity: signature`, one for each identity from 0 on"}, 2,
                                              static_cast<std::int64_t>(Signature::kMaxBins), 100));
  s.misreading_probability = config.number_in(
      {"misreading_probability", "of `identity: signature`, shared by all identities but the one that was read"}, 1e-6,
      0.5, 0.01);
  return s;
}

ExistenceSettings read_existence(const Config& config) {
  ExistenceSettings s;
  s.min_observations = static_cast<int>(
      config.integer_in({"min_observations", "sightings until which a landmark is provisional"}, 1, 1000, 3));
  s.log_odds_hit = config.positive({"log_odds_hit", "added to the log-odds of a landmark that is seen"}, 0.7);
  s.log_odds_miss = config.number_in(
      {"log_odds_miss", "added to the log-odds of a landmark that is not seen where it should be"}, -100.0, 0.0, -0.4);
  s.log_odds_max = config.positive({"log_odds_max", "upper bound of the log-odds"}, 5.0);
  s.delete_below = config.number({"delete_below", "log-odds below which a confirmed landmark is deleted"}, -2.0);
  s.delete_provisional_below =
      config.number({"delete_provisional_below", "log-odds below which a provisional landmark is deleted"}, -0.9);
  s.view_range = config.positive({"view_range_m", "m", "a landmark must be detected up to this range"}, 25.0);
  s.view_half_angle =
      kRadPerDeg * config.number_in({"view_half_angle_deg", "°",
                                     "a landmark must be detected up to this angle from the sensor's axis"},
                                    0.0, 180.0, 86.0);
  s.free_margin = config.positive(
      {"free_margin_m", "m", "a landmark must be detected where the beams read this much beyond it"}, 1.0);
  s.max_misses = static_cast<int>(
      config.integer_in({"max_misses", "factors of missed landmarks in the weight, per scan"}, 0, 1000, 3));
  return s;
}

}  // namespace

FeatureMapSettings FeatureMapSettings::read(const Config& config, bool with_camera) {
  FeatureMapSettings s;
  for (const std::string& attribute : config.texts(
           {"attributes", "of a landmark, besides its position: `radius`, `signature`"}, std::vector<std::string>{})) {
    if (attribute == "radius") {
      s.use_radius = true;
    } else if (attribute == "signature") {
      s.use_signature = true;
    } else {
      config.fail("attributes", "\"" + attribute + "\" is not an attribute; possible are radius, signature");
    }
  }
  s.use_negative_information =
      config.boolean({"negative_information", "count landmarks that should have been seen"}, true);
  s.keep_sightings = config.boolean(
      {"keep_sightings", "store which detection went into which landmark, to score the association"}, false);
  s.identity = read_identity(config);
  s.identity_signature =
      read_identity_signature(config.child_or_empty({"signature", "signatures of `identity: signature`"}));
  if (s.identity == IdentityUse::signature) s.use_signature = true;
  s.extraction = read_extraction(config.child_or_empty({"extraction", "how cylinders are found in a scan"}));
  if (with_camera) {
    s.camera =
        read_camera(config.child_or_empty({"camera", "what the camera adds; only with a camera among the inputs"}));
    if (s.identity != IdentityUse::unused) config.fail("identity", "must be unused with a camera: scans read none");
  } else if (config.has("camera")) {
    config.fail("camera", "none of the inputs is a camera, a sensor with `payload: Image`");
  }
  s.noise = read_noise(config.child_or_empty({"noise", "σ of one detection"}));
  s.association = read_association(config.child_or_empty({"association", "which landmark a detection belongs to"}),
                                   s.use_radius ? 3 : 2, s.camera);
  s.existence = read_existence(config.child_or_empty({"existence", "birth and death of landmarks"}));
  s.load = map_formats::LoadSettings::read(config, map_formats::kLandmarksFormat);
  return s;
}

std::size_t FeatureMapSettings::signature_bins() const {
  if (!use_signature) return 0;
  if (camera) return static_cast<std::size_t>(camera->hue_bins) * static_cast<std::size_t>(camera->saturation_bins);
  constexpr std::size_t kReflectivityBins = 2;  // dark, bright
  return identity == IdentityUse::signature ? static_cast<std::size_t>(identity_signature.bins) : kReflectivityBins;
}

}  // namespace waymark::feature_map
