// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cloud_file/cloud_layout.hpp"
#include "plugins/shared/compression/byte_stream.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::cloud_file {

/// Which points of a cloud are taken.
struct Thinning {
  std::uint32_t every = 1;              ///< every n-th one
  std::uint32_t at_most = kMostPoints;  ///< of those so many, spread evenly over the cloud
};

/// Reads a file of clouds one by one (cloud_layout.hpp). A number that the file states is believed only as far as the
/// rest of the file can hold it, and memory grows with what was read.
class CloudReader {
 public:
  /// The beginning of a cloud.
  struct Head {
    std::uint32_t number = 0;   ///< counted from 0
    std::optional<Time> stamp;  ///< nothing if it is no stamp
    std::uint32_t points = 0;
  };

  /// Reads the file's head. Throws DataError if it cannot be opened, or is no such file.
  explicit CloudReader(const std::filesystem::path& file);

  std::uint32_t clouds() const { return clouds_; }  ///< as the file states
  bool has_intensities() const { return (has_ & kHasIntensities) != 0; }
  bool has_times() const { return (has_ & kHasTimes) != 0; }

  /// The next cloud's head; nothing behind the last one. Passes over points of the one before that were not read.
  /// Throws DataError, with cloud and byte, where the file ends early, is damaged or goes on behind its last cloud.
  std::optional<Head> next();
  /// The points of that cloud. Points that are not finite are left out; the result is their number. Throws DataError as
  /// `next` does.
  std::size_t read(const Thinning& thinning, PointCloud& cloud);

  std::string place() const;  ///< "file:cloud n"
  double progress() const;    ///< 0..1

 private:
  void fill(char* data, std::size_t size, std::string_view what);
  void pass_over();
  [[noreturn]] void fail(const std::string& problem) const;

  std::string name_;
  compression::ByteStream bytes_;
  bool is_compact_ = true;
  std::uint32_t clouds_ = 0;
  std::uint32_t has_ = 0;
  std::size_t point_bytes_ = 0;
  std::uint32_t next_ = 0;    // number of the next cloud
  std::uint32_t unread_ = 0;  // points of the current one
  std::vector<char> buffer_;
};

}  // namespace waymark::cloud_file
