// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace waymark::feature_map {

struct ImageSize {
  std::int64_t width = 0;
  std::int64_t height = 0;
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

/// The size [px] that the header of a PNG or JPEG file claims, read without decoding: a small file may unpack to
/// gigabytes. Nothing for other formats and for a header that is cut off.
std::optional<ImageSize> size_in_header(std::span<const std::uint8_t> file);

}  // namespace waymark::feature_map
