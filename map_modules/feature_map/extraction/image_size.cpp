// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/image_size.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace waymark::feature_map {

namespace {

using Bytes = std::span<const std::uint8_t>;

/// A number of `count` bytes, the highest first.
std::int64_t big_endian(Bytes file, std::size_t at, std::size_t count) {
  std::int64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | file[at + i];
  return value;
}

/// PNG (ISO/IEC 15948, 11.2.2): the signature, then the chunk IHDR with width and height.
std::optional<ImageSize> size_of_png(Bytes file) {
  constexpr std::array<std::uint8_t, 4> kHeader{'I', 'H', 'D', 'R'};
  if (file.size() < 24 || !std::ranges::equal(file.subspan(12, 4), kHeader)) return std::nullopt;
  return ImageSize{big_endian(file, 16, 4), big_endian(file, 20, 4)};
}

/// JPEG (ITU-T T.81, B.1 and B.2.2): segments, one after the other; that of a frame (SOFn) has height and width.
std::optional<ImageSize> size_of_jpeg(Bytes file) {
  std::size_t at = 2;
  while (at + 4 <= file.size()) {
    if (file[at] != 0xff) return std::nullopt;
    const std::uint8_t marker = file[at + 1];
    if (marker == 0xff) {  // fill
      ++at;
      continue;
    }
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) {  // without a length
      at += 2;
      continue;
    }
    const bool no_frame = marker == 0xc4 || marker == 0xc8 || marker == 0xcc;
    if (marker >= 0xc0 && marker <= 0xcf && !no_frame) {
      if (at + 9 > file.size()) return std::nullopt;
      return ImageSize{big_endian(file, at + 7, 2), big_endian(file, at + 5, 2)};
    }
    if (marker == 0xd9 || marker == 0xda) return std::nullopt;  // the end, or pixels, before a frame
    at += 2 + static_cast<std::size_t>(big_endian(file, at + 2, 2));
  }
  return std::nullopt;
}

}  // namespace

std::optional<ImageSize> size_in_header(Bytes file) {
  constexpr std::array<std::uint8_t, 8> kPng{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::array<std::uint8_t, 3> kJpeg{0xff, 0xd8, 0xff};
  const auto begins_with = [&](Bytes magic) {
    return file.size() >= magic.size() && std::ranges::equal(file.first(magic.size()), magic);
  };
  if (begins_with(kPng)) return size_of_png(file);
  if (begins_with(kJpeg)) return size_of_jpeg(file);
  return std::nullopt;
}

}  // namespace waymark::feature_map
