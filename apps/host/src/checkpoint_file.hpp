// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "waymark/interface/measurement.hpp"

namespace waymark::host {

/// The hash of nothing (FNV-1a).
inline constexpr std::uint64_t kEmptyHash = 0xcbf29ce484222325U;

/// The beginning of a log, to recognise it: stamps, arrivals and sensors of its first measurements.
class LogIdentity {
 public:
  void add(const Measurement& measurement);
  std::uint64_t hash() const { return hash_; }

 private:
  static constexpr std::uint64_t kMeasurements = 1000;

  std::uint64_t count_ = 0;
  std::uint64_t hash_ = kEmptyHash;
};

/// Of an effective configuration: all but `sinks`, `plugin_path` and `filter.threads`, which may differ in a run that
/// is resumed.
std::uint64_t identity_of(std::string_view effective_config);

/// What a checkpoint belongs to.
struct CheckpointIdentity {
  std::uint64_t config = 0;  ///< identity_of()
  std::uint64_t log = 0;     ///< LogIdentity::hash()
};

/// Writes the file with a checksum. Throws Error.
void write_checkpoint(const std::filesystem::path& file, const CheckpointIdentity& identity, std::string_view state);

/// Reads it into `identity` and returns the state. Throws Error if it cannot be read, is not a checkpoint of this
/// version, or was damaged.
std::string read_checkpoint(const std::filesystem::path& file, CheckpointIdentity& identity);

}  // namespace waymark::host
