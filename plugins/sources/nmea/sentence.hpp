// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/time.hpp"

namespace waymark::nmea {

/// Why a line cannot be used. Never leaves the plugin.
class Unusable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One sentence, "$ttSSS,field,field*hh". Views point into the line.
struct Sentence {
  std::string_view talker;               ///< GP, GN, …
  std::string_view type;                 ///< GGA, RMC, …
  std::vector<std::string_view> fields;  ///< behind the type

  /// The field, or an empty one if the sentence is shorter: older receivers leave off the newest fields.
  std::string_view field(std::size_t index) const { return index < fields.size() ? fields[index] : std::string_view(); }

  // Empty fields are unknown; what is none of its kind throws Unusable.
  std::optional<double> number(std::size_t index) const;
  std::optional<int> whole_number(std::size_t index) const;
  /// "hhmmss" or "hhmmss.ss", to the nanosecond.
  std::optional<Duration> time_of_day(std::size_t index) const;
  /// "ddmmyy"; years from 80 on are of the last century.
  std::optional<std::chrono::sys_days> date(std::size_t index) const;
  /// "ddmm.mmmm" in this field and `north` or `south` (or east, west) in the next one [deg].
  std::optional<double> angle(std::size_t index, char positive, char negative, double limit) const;
};

/// Reads a line. Nothing for blank lines, comments (#), sentences of others than receivers (!) and proprietary ones
/// ($P). Throws Unusable, also if the checksum is wrong, or is missing and `needs_checksum`.
std::optional<Sentence> read_sentence(std::string_view line, bool needs_checksum);

}  // namespace waymark::nmea
