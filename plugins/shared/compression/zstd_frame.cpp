// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/compression/zstd_frame.hpp"

#include <zstd.h>

#include <memory>
#include <stdexcept>

namespace waymark::compression {
namespace {

// Memory for the window of a frame: 128 MiB, as the program zstd has it without an option.
constexpr int kLargestWindowLog = 27;

struct FreeDecompressor {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
struct FreeCompressor {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

}  // namespace

std::vector<std::uint8_t> compress_zstd(std::span<const std::uint8_t> bytes, int level) {
  const std::unique_ptr<ZSTD_CCtx, FreeCompressor> context(ZSTD_createCCtx());
  if (!context) throw std::bad_alloc();
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::vector<std::uint8_t> frame(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress2(context.get(), frame.data(), frame.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size) != 0) throw std::runtime_error(ZSTD_getErrorName(size));
  frame.resize(size);
  return frame;
}

Decompressed decompress_zstd(std::span<const std::uint8_t> stored, std::size_t expected) {
  Decompressed result;
  const std::unique_ptr<ZSTD_DCtx, FreeDecompressor> context(ZSTD_createDCtx());
  if (!context) return {{}, "libzstd cannot start"};
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindowLog);
  ZSTD_inBuffer in{stored.data(), stored.size(), 0};
  std::size_t used = 0;
  for (std::size_t wanted = 1;;) {
    if (used == result.bytes.size()) {
      if (used > expected) break;
      make_room(result.bytes, used, expected);
    }
    ZSTD_outBuffer out{result.bytes.data(), result.bytes.size(), used};
    const std::size_t consumed = in.pos;
    wanted = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(wanted) != 0)
      return {{}, std::string("the zstd data are damaged (") + ZSTD_getErrorName(wanted) + ")"};
    const bool stuck = out.pos == used && in.pos == consumed;
    used = out.pos;
    if (wanted == 0 && in.pos == in.size) break;
    if (stuck && out.pos < out.size) {
      result.problem = "the zstd data end early";
      break;
    }
  }
  result.bytes.resize(used);
  return result;
}

}  // namespace waymark::compression
