// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace waymark::cloud_file {

// A file of clouds, plain or gzip, little-endian without padding: eight bytes that name the version, the number of
// clouds (uint32), and the clouds one after the other.
//
//     PTS30001   uint32 clouds;               per cloud: float64 t [s], uint32 n, n × int16 x, y, z in units of 2 mm
//     PTS30002   uint32 clouds, uint32 has;   per cloud: int64 t [ns], uint32 n, n × float32 x, y, z [m] and, by the
//                                             bits of `has`, float32 intensity (1), float32 time after t [s] (2)
static_assert(std::endian::native == std::endian::little);

inline constexpr std::string_view kCompact = "PTS30001";
inline constexpr std::string_view kFull = "PTS30002";

inline constexpr double kCompactUnit = 0.002;
inline constexpr std::uint32_t kHasIntensities = 1;
inline constexpr std::uint32_t kHasTimes = 2;

inline constexpr std::size_t kHeadBytes = 12;  ///< of a cloud: its time and its number of points
/// No scanner has more in a turn; a cloud takes 0.2 to 0.3 GB then.
inline constexpr std::uint32_t kMostPoints = 1U << 24;

}  // namespace waymark::cloud_file
