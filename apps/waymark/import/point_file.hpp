// SPDX-License-Identifier: Apache-2.0
// One cloud in a file of its own: PCD of the Point Cloud Library, or a table.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::imports {

struct PointFile {
  PointCloud cloud;            ///< intensities and times if the file has them
  std::size_t not_finite = 0;  ///< points that were left out
  std::vector<std::string> notes;
};

/// Reads a file, plain or gzip, by its name: .pcd (and .pcd.gz) as PCD, what else as a table. Times of points count
/// from `stamp`. Throws DataError with file and line or byte.
PointFile read_point_file(const std::filesystem::path& file, Time stamp);

/// `content` of a PCD, version 0.7: ascii, binary or binary_compressed. x, y, z are required; `intensity` and one of
/// `t`, `time`, `time_stamp`, `timestamp`, `offset_time` are taken, other fields passed over. Throws DataError, which
/// begins with `name`.
PointFile read_pcd(std::string_view content, const std::string& name, Time stamp);

/// `content` of a table: a point on each line, numbers between commas, semicolons, tabs or spaces. A header names the
/// columns x, y, z and, if there are such, intensity and t; without one the first three are x, y, z. Throws DataError,
/// which begins with `name`.
PointFile read_point_table(std::string_view content, const std::string& name, Time stamp);

/// Takes points one by one, as all formats have them.
class PointCollector {
 public:
  PointCollector(PointFile& file, bool intensities, bool times)
      : file_(file), intensities_(intensities), times_(times) {}

  /// A point that is not finite, or whose time is not, is left out.
  void add(const Eigen::Vector3f& p, double intensity, double time_s);

 private:
  PointFile& file_;
  bool intensities_;
  bool times_;
};

/// Time of a point after `stamp` [s]: a whole number is nanoseconds after it, another one seconds; what is more than a
/// year is a time of the clock, in seconds or nanoseconds.
double seconds_after(Time stamp, double value, bool is_whole);

bool is_time_of_point(std::string_view field);  ///< `t`, `time`, …

}  // namespace waymark::imports
