// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/import/whole_file.hpp"

#include <fmt/format.h>

#include <array>

#include "plugins/shared/compression/byte_stream.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {

std::string read_whole(const std::filesystem::path& file, std::size_t most, std::string_view limit) {
  const std::string name = file.string();
  std::string content;
  compression::ByteStream bytes(file);
  std::array<char, 1 << 16> piece;
  while (const std::size_t count = bytes.read(piece.data(), piece.size())) {
    content.append(piece.data(), count);
    if (content.size() > most) throw DataError(fmt::format("{}: is larger than {}", name, limit));
  }
  if (!bytes.problem().empty()) throw DataError(fmt::format("{}: {}", name, bytes.problem()));
  return content;
}

}  // namespace waymark::imports
