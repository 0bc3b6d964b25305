// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "plugins/shared/cloud_file/cloud_layout.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::cloud_file {

/// Writes a file of clouds (PTS30002, cloud_layout.hpp): gzip if its name ends in .gz, plain otherwise. It appears
/// under its name when it is complete.
class CloudWriter {
 public:
  /// What all clouds of the file have.
  struct Contents {
    std::uint32_t clouds = 0;
    bool intensities = false;
    bool times = false;
  };

  /// Throws DataError if the file cannot be written.
  CloudWriter(const std::filesystem::path& file, const Contents& contents);
  ~CloudWriter();
  CloudWriter(const CloudWriter&) = delete;
  CloudWriter& operator=(const CloudWriter&) = delete;

  /// Adds the next cloud. Throws DataError if it cannot be written, is not later than the one before, is one more than
  /// was stated, has more than `kMostPoints`, or has other fields than was stated.
  void add(Time stamp, const PointCloud& cloud);
  /// To be called after the last one. Throws DataError if there are fewer than was stated, or it cannot be written.
  void finish();

 private:
  class Deflater;

  void write(std::string_view bytes);

  std::string name_;
  Contents contents_;
  std::uint32_t written_ = 0;
  Time newest_ = Time::min();
  OutputFile out_;
  std::unique_ptr<Deflater> deflater_;  // null: plain
  std::string bytes_;                   // of one cloud
};

}  // namespace waymark::cloud_file
