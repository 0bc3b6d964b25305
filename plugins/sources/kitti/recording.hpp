// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::kitti {

/// One stream of a raw recording: a folder with `data/<number>.<ending>` and perhaps `timestamps.txt`.
class Stream {
 public:
  /// Lists the files whose name is a number and ends in one of `endings`; where two have one number, the earlier ending
  /// wins. Throws DataError if there is no such folder or file, or the stamps cannot be read.
  Stream(const std::filesystem::path& folder, const std::vector<std::string>& endings);

  /// File of each frame.
  const std::map<std::uint64_t, std::filesystem::path>& files() const { return files_; }
  /// Where the file of a frame that is missing should have been.
  std::filesystem::path expected(std::uint64_t frame) const;
  bool has_stamps() const { return stamps_.has_value(); }
  /// Of the frame: line `frame` of timestamps.txt, counted from 0. Nothing if there is no such line or file.
  std::optional<Time> stamp(std::uint64_t frame) const;
  std::filesystem::path stamps_file() const { return folder_ / "timestamps.txt"; }

 private:
  std::filesystem::path folder_;
  std::string ending_;
  std::map<std::uint64_t, std::filesystem::path> files_;
  std::optional<std::vector<Time>> stamps_;
};

/// All frames of one stream or two, in the order of time.
struct Entry {
  Time stamp;
  std::uint32_t stream = 0;
  std::filesystem::path file;
  std::string problem;  ///< why there is nothing to be read; empty: there is
};

/// Where the stamps of a stream come from.
struct StampRule {
  const Stream* stream = nullptr;
  const Stream* stamps = nullptr;  ///< whose timestamps.txt is taken
};

/// Streams merged by time, equal stamps in the order of `streams`. A frame that only another stream has, that has no
/// stamp or one that is not later than the frame before, becomes an entry with a problem. Without a timestamps.txt
/// frame N is at N · `period`.
std::vector<Entry> schedule(const std::vector<StampRule>& streams, Duration period);

/// The floats of a file, plain or (if its name ends in .gz) gzip, into `values`. Throws Unusable if the file cannot be
/// read, is damaged, or holds no whole number of points of four floats.
void read_points(const std::filesystem::path& file, std::vector<float>& values);

/// Of `points` (x, y, z [m] and reflectance, one after the other) every n-th one. Points that are not finite are left
/// out; the result is their number.
std::size_t take_points(std::span<const float> points, std::size_t every, PointCloud& cloud);

/// The bytes of a file. Throws Unusable if it cannot be read or is empty.
std::vector<std::uint8_t> read_bytes(const std::filesystem::path& file);

}  // namespace waymark::kitti
