// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "waymark/archive.hpp"
#include "waymark/source.hpp"

namespace waymark::kitti {

/// A frame of the recording that cannot be used. Never leaves the source.
class Unusable : public std::runtime_error {
 public:
  Unusable(std::string place, const std::string& reason) : std::runtime_error(reason), place_(std::move(place)) {}
  const std::string& place() const { return place_; }  ///< the file

 private:
  std::string place_;
};

/// What was wrong in the recording, up to a limit.
class BadRecords {
 public:
  explicit BadRecords(std::uint64_t limit) : limit_(limit) {}

  /// Counts one. Throws DataError with its place and reason if it is one too many.
  void add(const std::string& place, const std::string& reason);

  const std::vector<BadRecord>& records() const { return records_; }  ///< the first 1000

  void save(OutArchive& archive) const;
  void load(InArchive& archive);

 private:
  std::uint64_t limit_;
  std::uint64_t count_ = 0;
  std::vector<BadRecord> records_;
};

}  // namespace waymark::kitti
