// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "map_modules/feature_map/extraction/extraction_pictures.hpp"
#include "waymark/config/config.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::feature_map {

/// Every candidate of every scan as one row of a CSV file: the results of the extraction on a recording, for measuring.
///
///     t_s,first_beam,last_beam,verdict,range_m,bearing_rad,radius_m,x_m,y_m,in_image,radius_sigma_m,signature
///
/// `range_m` is the mean over the beams, `x_m`, `y_m` the centre in the base frame; `in_image` is 1 if the image that
/// belongs to the scan shows the candidate, then `radius_m` is measured there. `signature` holds the bins, parted by
/// semicolons. An empty field is unknown.
class ExtractionTable {
 public:
  /// The file that `key` names, relative to the working directory; none if it is absent: no table. Its folder is made
  /// if it is not there. Throws ConfigError.
  ExtractionTable(const Config& config, const Config::Key& key);
  /// The file gets its name. An error of the disk at this last moment is lost.
  ~ExtractionTable();
  ExtractionTable(const ExtractionTable&) = delete;
  ExtractionTable& operator=(const ExtractionTable&) = delete;

  /// Throws Error if the file cannot be written.
  void take(const ExtractionFrame& frame);

 private:
  std::filesystem::path path_;
  std::optional<OutputFile> file_;  // made with the first scan
};

}  // namespace waymark::feature_map
