// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace waymark::compression {

/// What came out of compressed bytes, as far as it goes.
struct Decompressed {
  std::vector<std::uint8_t> bytes;
  std::string problem;  ///< why there is no more; empty: the compressed data are whole
};

/// Makes room behind `used` bytes step by step, since a damaged size must not claim the whole memory at once. One byte
/// more than `expected` shows that there are more.
inline void make_room(std::vector<std::uint8_t>& bytes, std::size_t used, std::size_t expected) {
  constexpr std::size_t kStep = std::size_t{1} << 22;
  bytes.resize(std::min(std::max(used + kStep, 2 * used), expected + 1));
}

}  // namespace waymark::compression
