// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace waymark::imports {

/// The content of a file, plain or gzip. Throws DataError if it cannot be read, or if it has more than `most` bytes:
/// "FILE: is larger than `limit`".
std::string read_whole(const std::filesystem::path& file, std::size_t most, std::string_view limit);

}  // namespace waymark::imports
