// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "map_modules/feature_map/extraction/camera_view.hpp"
#include "map_modules/feature_map/extraction/cylinder_extraction.hpp"
#include "map_modules/feature_map/extraction/image_decoding.hpp"

namespace waymark::feature_map {

/// The measurement of one candidate in the image.
struct CandidateLook {
  std::size_t candidate = 0;  ///< its index
  bool has_edges = false;     ///< if not, `corners` are where they were expected
  /// The region: upper left, upper right, lower right, lower left [px].
  std::array<Eigen::Vector2d, 4> corners{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                         Eigen::Vector2d::Zero()};
  double radius_sigma = 0.0;  ///< of the candidate's radius, which is now that of the image [m]
  Signature signature;        ///< unknown where the region is too dark
};

/// The image that belongs to a scan, with the measurements of its candidates.
struct ImageLook {
  DecodedImage image;
  std::optional<CameraView> camera;  ///< where the image was taken; absent without one
  std::vector<CandidateLook> looks;  ///< of those that lie in the image, in the order of the candidates

  /// The measurement of one candidate; null if it does not lie in the image.
  const CandidateLook* of(std::size_t candidate) const;
};

/// Extraction (b) of §4.1: looks at the candidates of a scan in an image that was taken a little earlier. Candidates
/// without a pair of vertical edges are discarded (`Verdict::no_edges`); for the others the width between the edges
/// gives the radius, and the region between them the signature.
class CameraExtraction {
 public:
  CameraExtraction(const Intrinsics& intrinsics, const Pose& T_base_camera, const CameraSettings& settings,
                   double range_sigma)
      : intrinsics_(intrinsics), T_base_camera_(T_base_camera), settings_(settings), range_sigma_(range_sigma) {}

  /// Judges the accepted ones of `candidates`, which a scanner at `T_base_scanner` saw at `stamp`. Without a usable
  /// image they stay as they are. `image` is null or holds an `Image` not later than `stamp`.
  ImageLook look(const Measurement* image, Time stamp, const MotionWindow& motion, const Pose& T_base_scanner,
                 std::vector<Candidate>& candidates);

 private:
  /// False if the candidate lies outside of the image.
  bool look_at(Candidate& candidate, const Pose& T_base_scanner, const ImageLook& image, CandidateLook& look) const;
  void measure_radius(Candidate& candidate, const Pose& T_base_scanner, const CameraView& camera, double left_slope,
                      double right_slope, CandidateLook& look) const;

  Intrinsics intrinsics_;
  Pose T_base_camera_;
  CameraSettings settings_;
  double range_sigma_;
  // Several scans may share one image, and decoding costs most.
  Time decoded_stamp_{};
  std::uint64_t decoded_sequence_ = 0;
  DecodedImage decoded_;
};

}  // namespace waymark::feature_map
