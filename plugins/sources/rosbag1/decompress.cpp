// SPDX-License-Identifier: Apache-2.0
#include "decompress.hpp"

#include <bzlib.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "plugins/shared/compression/lz4_frame.hpp"

namespace waymark::rosbag1 {
namespace {

struct CloseBzip2 {
  void operator()(bz_stream* stream) const {
    BZ2_bzDecompressEnd(stream);
    delete stream;  // NOLINT(cppcoreguidelines-owning-memory): the deleter of a unique_ptr
  }
};

Decompressed bzip2(ros::Bytes stored, std::size_t size) {
  Decompressed result;
  const std::unique_ptr<bz_stream, CloseBzip2> stream(new bz_stream{});
  if (BZ2_bzDecompressInit(stream.get(), 0, 0) != BZ_OK) return {{}, "libbz2 cannot start"};
  // libbz2 does not write to what it reads.
  stream->next_in = const_cast<char*>(reinterpret_cast<const char*>(stored.data()));  // NOLINT
  stream->avail_in = static_cast<unsigned>(stored.size());
  std::size_t used = 0;
  for (int status = BZ_OK; status == BZ_OK;) {
    if (used == result.bytes.size()) {
      if (used > size) break;
      compression::make_room(result.bytes, used, size);
    }
    stream->next_out = reinterpret_cast<char*>(result.bytes.data()) + used;
    stream->avail_out = static_cast<unsigned>(result.bytes.size() - used);
    const std::size_t before = used;
    status = BZ2_bzDecompress(stream.get());
    used = result.bytes.size() - stream->avail_out;
    if (status == BZ_STREAM_END) break;
    if (status != BZ_OK) {
      return {{}, "the bz2 data are damaged"};  // the checksum comes last: what came out may be wrong
    } else if (stream->avail_in == 0 && used == before) {
      result.problem = "the bz2 data end early";
      break;
    }
  }
  result.bytes.resize(used);
  return result;
}

}  // namespace

std::uint64_t most_unpacked(std::uint64_t stored) {
  constexpr std::uint64_t kRatio = 255;
  constexpr std::uint64_t kOfAny = std::uint64_t{1} << 25;
  return kOfAny + kRatio * stored;
}

bool knows_compression(std::string_view name) { return name == "none" || name == "bz2" || name == "lz4"; }

Decompressed decompress(std::string_view compression, ros::Bytes stored, std::size_t size) {
  Decompressed result = compression == "bz2"   ? bzip2(stored, size)
                        : compression == "lz4" ? compression::decompress_lz4(stored, size)
                                               : Decompressed{{stored.begin(), stored.end()}, {}};
  if (result.problem.empty() && result.bytes.size() != size) {
    result.problem = fmt::format("{} uncompressed bytes, {} are expected", result.bytes.size(), size);
  }
  if (result.bytes.size() > size) result.bytes.resize(size);
  return result;
}

}  // namespace waymark::rosbag1
