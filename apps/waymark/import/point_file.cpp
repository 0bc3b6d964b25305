// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/import/point_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "apps/waymark/import/whole_file.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {
namespace {

constexpr std::size_t kMostCloudBytes = std::size_t{1} << 30;
constexpr std::array<std::string_view, 5> kTimes{"t", "time", "time_stamp", "timestamp", "offset_time"};

}  // namespace

bool is_time_of_point(std::string_view field) { return std::ranges::find(kTimes, field) != kTimes.end(); }

double seconds_after(Time stamp, double value, bool is_whole) {
  constexpr double kYear_s = 3.2e7;
  if (value > 1e9 * kYear_s) return 1e-9 * (value - static_cast<double>(stamp.time_since_epoch().count()));
  if (is_whole) return 1e-9 * value;
  return value > kYear_s ? value - to_seconds(stamp.time_since_epoch()) : value;
}

void PointCollector::add(const Eigen::Vector3f& p, double intensity, double time_s) {
  if (!p.allFinite() || (times_ && !std::isfinite(static_cast<float>(time_s)))) {
    ++file_.not_finite;
    return;
  }
  file_.cloud.points_m.push_back(p);
  const auto value = static_cast<float>(intensity);
  if (intensities_)
    file_.cloud.intensities.push_back(std::isfinite(value) ? value : std::numeric_limits<float>::quiet_NaN());
  if (times_) file_.cloud.offsets_s.push_back(static_cast<float>(time_s));
}

PointFile read_point_file(const std::filesystem::path& file, Time stamp) {
  const std::string name = file.string();
  const std::string content = read_whole(file, kMostCloudBytes, "1 GiB, which no cloud is");
  const std::filesystem::path plain = file.extension() == ".gz" ? file.stem() : file;
  return plain.extension() == ".pcd" ? read_pcd(content, name, stamp) : read_point_table(content, name, stamp);
}

}  // namespace waymark::imports
