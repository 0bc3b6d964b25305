// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "map_modules/feature_map/extraction/camera_extraction.hpp"
#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::feature_map {

/// A scan as seen from above in the sensor's frame (x up, y to the left), as a PNG file: accepted candidates in green
/// with their circle, dropped ones in the colour of the reason, a legend with counts. Throws Error if it cannot be
/// encoded.
std::string draw_extraction(const ScanView& view, const std::vector<Candidate>& candidates,
                            const ExtractionSettings& settings, const std::string& title);

/// What was extracted from one scan, for a picture.
struct ExtractionFrame {
  Time stamp;
  const ScanView& view;
  const std::vector<Candidate>& candidates;
  Pose T_base_scanner = {};
  const ImageLook* look = nullptr;  ///< null without a camera
};

/// Draws the scans at given times, one file each: `extraction_pictures: { times_s: [10, 500], folder: "out/scans" }`;
/// with a camera also the image that belongs to it (camera_picture.hpp).
class ExtractionPictures {
 public:
  /// Reads the node; an empty one means no picture. Times count from the first scan, ascending; `folder`, relative
  /// to the working directory, is made if it is not there. Throws ConfigError.
  explicit ExtractionPictures(const Config& config);

  /// Draws the first scan not earlier than each time. Throws Error if the file cannot be written.
  void take(const ExtractionFrame& frame, const FeatureMapSettings& settings);

 private:
  std::vector<double> times_s_;
  std::filesystem::path folder_;
  std::size_t next_ = 0;
  std::optional<Time> first_;
};

}  // namespace waymark::feature_map
