// SPDX-License-Identifier: Apache-2.0
#include "decompress.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>

#include <algorithm>
#include <memory>

namespace waymark::rosbag1 {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 22;  // a damaged size must not claim the whole memory at once

/// Room for more of `expected` bytes behind the `used` ones; one byte too many shows that there are more than expected.
void make_room(std::vector<std::uint8_t>& bytes, std::size_t used, std::size_t expected) {
  bytes.resize(std::min(std::max(used + kStep, 2 * used), expected + 1));
}

struct CloseBzip2 {
  void operator()(bz_stream* stream) const {
    BZ2_bzDecompressEnd(stream);
    delete stream;  // NOLINT(cppcoreguidelines-owning-memory): the deleter of a unique_ptr
  }
};

Decompressed bzip2(Bytes stored, std::size_t size) {
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
      make_room(result.bytes, used, size);
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

struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

Decompressed lz4(Bytes stored, std::size_t size) {
  Decompressed result;
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) return {{}, "liblz4 cannot start"};
  const std::unique_ptr<LZ4F_dctx, FreeLz4> context(raw);
  std::size_t used = 0;
  for (std::size_t read = 0;;) {
    if (used == result.bytes.size()) {
      if (used > size) break;
      make_room(result.bytes, used, size);
    }
    std::size_t written = result.bytes.size() - used;
    std::size_t consumed = stored.size() - read;
    const std::size_t wanted =
        LZ4F_decompress(context.get(), result.bytes.data() + used, &written, stored.data() + read, &consumed, nullptr);
    used += written;
    read += consumed;
    if (LZ4F_isError(wanted) != 0) return {{}, fmt::format("the lz4 data are damaged ({})", LZ4F_getErrorName(wanted))};
    if (wanted == 0) break;
    if (written == 0 && consumed == 0) {
      result.problem = "the lz4 data end early";
      break;
    }
  }
  result.bytes.resize(used);
  return result;
}

}  // namespace

bool knows_compression(std::string_view name) { return name == "none" || name == "bz2" || name == "lz4"; }

Decompressed decompress(std::string_view compression, Bytes stored, std::size_t size) {
  Decompressed result = compression == "bz2"   ? bzip2(stored, size)
                        : compression == "lz4" ? lz4(stored, size)
                                               : Decompressed{{stored.begin(), stored.end()}, {}};
  if (result.problem.empty() && result.bytes.size() != size) {
    result.problem = fmt::format("{} uncompressed bytes, {} are expected", result.bytes.size(), size);
  }
  if (result.bytes.size() > size) result.bytes.resize(size);
  return result;
}

}  // namespace waymark::rosbag1
