// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "plugins/shared/map_formats/load_settings.hpp"
#include "waymark/config/config.hpp"

namespace waymark::feature_map {

/// How cylinders are found in a planar scan.
struct ExtractionSettings {
  double range_min;     ///< nearer returns are the robot itself [m]
  double range_max;     ///< farther returns make no candidate [m]
  double no_return;     ///< readings at or above this mean that nothing came back [m]
  double segment_jump;  ///< neighbouring beams that differ by more belong to two things [m]
  double background;    ///< the surroundings must be this much farther on both sides [m]
  double width_max;     ///< wider things are not a trunk or pillar [m]
  double isolation;     ///< no other return within this distance of the centre [m]; 0: off
  int min_beams;
  double bright_above;  ///< intensity above which a beam counts as a glint; infinity: not used
};

/// What is done with a candidate of the scan that no usable image shows.
enum class Unseen {
  keep,   ///< it is as good as any other
  match,  ///< it may be a landmark of the map, but it makes no new one
  drop
};

/// What the camera adds (§4.1).
struct CameraSettings {
  int hue_bins;
  int saturation_bins;
  double value_min;          ///< darker pixels have no colour, 0..1
  double edge_min_contrast;  ///< [grey levels of 255]
  double edge_min_cover;     ///< share of the height on which an edge must have that contrast
  double edge_below;         ///< rows this far below the scan are looked at [m]
  double edge_above;         ///< and above it [m]
  double edge_search;        ///< about each border that the scan predicts [rad]
  double edge_sigma_px;      ///< noise of one edge, σ [px]
  double width_ratio_min;    ///< of the width in the image to that in the scan
  double width_ratio_max;
  Unseen unseen;
};

/// Noise of one detection in the scanner's frame, σ.
struct DetectionNoise {
  double range;              ///< [m]
  double bearing;            ///< [rad]
  double tangential;         ///< constant part across the beam: where on the trunk the beams hit [m]
  double radius;             ///< [m]
  double range_share = 0.0;  ///< of the range: what grows with it, beside `range`
  double correlation = 0.0;  ///< time constant of the errors of one landmark's detections [s]; 0: independent
};

/// What an identity that a device read off a landmark (a barcode, a tag) is good for.
enum class IdentityUse {
  unused,     ///< nothing: landmarks look alike
  signature,  ///< a signature with one bin per identity; a misreading is possible
  known       ///< it decides alone which landmark a detection belongs to
};

/// An identity as a discrete distribution over `bins` identities, 0 to bins − 1.
struct IdentitySignature {
  int bins;
  double misreading_probability;  ///< shared equally by all identities but the one that was read
};

/// How the pairs are chosen when several are possible.
enum class AssociationMethod {
  greedy,  ///< the likeliest first
  optimal  ///< the greatest sum of log likelihoods
};

/// How a landmark's signature is fused with another view.
enum class SignatureFusion {
  product,   ///< discrete Bayes filter (4.10), with a floor
  dirichlet  ///< mean of a Dirichlet distribution that counts views: their running mean
};

/// How detections are associated with landmarks.
struct AssociationSettings {
  AssociationMethod method;
  double gate;                      ///< χ² bound on νᵀ Z⁻¹ ν
  double identity_gate;             ///< the same where the identity is known, wide: only an outlier fails it
  double new_landmark_density;      ///< ρ_new [1/m²]
  double detection_probability;     ///< P_D
  double log_min_likelihood_ratio;  ///< an association must be this much likelier than one with any other landmark; 0:
                                    ///< not asked
  double min_separation;            ///< two landmarks cannot stand closer [m]
  bool merge;                       ///< merge landmarks that have come closer than that and agree
  double radius_range;              ///< r_max − r_min [m]: the density of a radius among new landmarks
  double signature_lambda;          ///< λ of (4.7)
  SignatureFusion signature_fusion;
  double signature_floor;  ///< no bin falls below this (of the product)
  /// D of a new landmark in p₀; NaN: the running mean of D between detections and other landmarks
  double new_landmark_signature_distance;
};

/// Birth and death of landmarks.
struct ExistenceSettings {
  int min_observations;  ///< until then a landmark is provisional
  double log_odds_hit;
  double log_odds_miss;  ///< negative
  double log_odds_max;
  double delete_below;  ///< of confirmed landmarks
  double delete_provisional_below;
  double view_range;       ///< a landmark farther away may be missed without blame [m]
  double view_half_angle;  ///< from the sensor's axis [rad]
  double free_margin;      ///< beams must read this much beyond it [m]
  int max_misses;          ///< factors of missed landmarks in the weight: misses are correlated
};

struct FeatureMapSettings {
  bool use_radius = false;
  bool use_signature = false;
  bool use_negative_information = true;
  bool keep_sightings = false;  ///< which detection went into which landmark, over the whole run
  IdentityUse identity = IdentityUse::unused;
  IdentitySignature identity_signature;
  ExtractionSettings extraction;
  std::optional<CameraSettings> camera;  ///< if an input is one
  DetectionNoise noise;
  AssociationSettings association;
  ExistenceSettings existence;
  map_formats::LoadSettings load;

  bool writes() const { return load.use != map_formats::MapUse::localize; }
  /// Of what detections bring; 0: they bring none.
  std::size_t signature_bins() const;

  /// Reads the map's node of the YAML; its key `camera` only if one of its inputs is a camera. Throws ConfigError.
  static FeatureMapSettings read(const Config& config, bool with_camera = false);
};

}  // namespace waymark::feature_map
