// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace waymark::imports {

/// Unpacks LZF (M. Lehmann, liblzf), as PCD's binary_compressed has it. Nothing if it is damaged, or does not unpack to
/// exactly `size` bytes.
std::optional<std::string> unpack_lzf(std::string_view packed, std::size_t size);

}  // namespace waymark::imports
