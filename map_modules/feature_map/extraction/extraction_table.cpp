// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/extraction_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark::feature_map {

ExtractionTable::ExtractionTable(const Config& config, const Config::Key& key) {
  if (config.has(key.name)) path_ = config.output(key, "");
}

ExtractionTable::~ExtractionTable() {
  if (!file_) return;
  try {
    file_->commit();
  } catch (const Error&) {  // NOLINT(bugprone-empty-catch): what fits is kept; a destructor cannot report it
  }
}

void ExtractionTable::take(const ExtractionFrame& frame) {
  if (path_.empty()) return;
  if (!file_) {
    if (path_.has_parent_path()) create_folder(path_.parent_path());
    file_.emplace(path_);
    file_->write(
        "t_s,first_beam,last_beam,verdict,range_m,bearing_rad,radius_m,x_m,y_m,in_image,radius_sigma_m,signature\n");
  }
  const std::string time = format_time(frame.stamp);
  for (std::size_t i = 0; i < frame.candidates.size(); ++i) {
    const Candidate& c = frame.candidates[i];
    const CandidateLook* seen = frame.look != nullptr ? frame.look->of(i) : nullptr;
    const double distance = c.surface_range + c.radius;
    const double bearing = frame.view.yaw_base_sensor + c.bearing;
    const Eigen::Vector2d center =
        frame.view.p_base_sensor + distance * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    std::string row = fmt::format("{},{},{},{},{:.4f},{:.6f},{:.4f},{:.4f},{:.4f},{},", time, c.first_beam, c.last_beam,
                                  name_of(c.verdict), c.mean_range, c.bearing, c.radius, center.x(), center.y(),
                                  seen != nullptr ? 1 : 0);
    const bool measured = seen != nullptr && seen->has_edges;
    if (measured) fmt::format_to(std::back_inserter(row), "{:.4f}", seen->radius_sigma);
    row += ',';
    if (measured) fmt::format_to(std::back_inserter(row), "{:.4g}", fmt::join(seen->signature, ";"));
    file_->write(row + '\n');
  }
}

}  // namespace waymark::feature_map
