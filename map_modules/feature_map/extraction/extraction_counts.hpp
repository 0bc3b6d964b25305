// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "map_modules/feature_map/extraction/camera_extraction.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::feature_map {

/// What has become of candidates and images so far, for reports.
class ExtractionCounts {
 public:
  void add(const std::vector<Candidate>& candidates);
  /// Also counts the accepted candidates that the image did not show.
  void add(const ImageLook& look, const std::vector<Candidate>& candidates);

  /// `candidates_accepted`, `candidates_too_wide`, …; of images only if there is a camera.
  void describe(bool with_camera, std::vector<MapFigure>& figures) const;
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("extraction_counts", 1);
    archive(candidates_, images_, not_shown_);
  }

 private:
  std::array<std::uint64_t, kVerdicts> candidates_{};
  std::array<std::uint64_t, kImageStates> images_{};
  std::uint64_t not_shown_ = 0;
};

}  // namespace waymark::feature_map
