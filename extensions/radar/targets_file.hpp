// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::radar {

/// One scan of a file.
struct Scan {
  Time stamp{};
  int radar = 0;  ///< its number in the file
  std::vector<RadarTargets::One> targets;
  std::vector<std::uint8_t> labels;  ///< by target, in the words of the recording; empty: it has none
};

/// A recording of radars, plain or gzip, read scan by scan. The format follows from the content:
/// - `RADT0001` (excerpts of RadarScenes): range, azimuth, radial velocity, cross-section, label;
/// - `RADC0001` (excerpts of nuScenes, ARS 408): position and velocity in the plane, cross-section, states; targets
///   that the radar calls invalid or ambiguous are left out;
/// - text with the columns `t_s`, `x_m`, `y_m`, `z_m` and `doppler_mps` (positive of a target that recedes), rows of
///   equal time form one scan of radar 0.
class TargetsFile {
 public:
  /// Throws DataError if the file cannot be read or is of none of these formats.
  static std::unique_ptr<TargetsFile> open(const std::filesystem::path& file);
  virtual ~TargetsFile() = default;

  /// The next scan, or nothing at the end. Throws DataError where the file is damaged, or where time goes back.
  std::optional<Scan> next();

  /// Share of the file that was read, 0 to 1.
  virtual double progress() const = 0;

 protected:
  virtual std::optional<Scan> read() = 0;
  /// Where the last scan lies, for messages: "targets.bin.gz: scan 17".
  virtual std::string place() const = 0;

 private:
  std::optional<Time> last_;
};

}  // namespace waymark::radar
