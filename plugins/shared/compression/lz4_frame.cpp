// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/compression/lz4_frame.hpp"

#include <lz4frame.h>

#include <memory>
#include <stdexcept>

namespace waymark::compression {
namespace {

struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

}  // namespace

std::vector<std::uint8_t> compress_lz4(std::span<const std::uint8_t> bytes) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  preferences.frameInfo.contentSize = bytes.size();
  std::vector<std::uint8_t> frame(LZ4F_compressFrameBound(bytes.size(), &preferences));
  const std::size_t size = LZ4F_compressFrame(frame.data(), frame.size(), bytes.data(), bytes.size(), &preferences);
  if (LZ4F_isError(size) != 0) throw std::runtime_error(LZ4F_getErrorName(size));
  frame.resize(size);
  return frame;
}

Decompressed decompress_lz4(std::span<const std::uint8_t> stored, std::size_t expected) {
  Decompressed result;
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) return {{}, "liblz4 cannot start"};
  const std::unique_ptr<LZ4F_dctx, FreeLz4> context(raw);
  std::size_t used = 0;
  for (std::size_t read = 0;;) {
    if (used == result.bytes.size()) {
      if (used > expected) break;
      make_room(result.bytes, used, expected);
    }
    std::size_t written = result.bytes.size() - used;
    std::size_t consumed = stored.size() - read;
    const std::size_t wanted =
        LZ4F_decompress(context.get(), result.bytes.data() + used, &written, stored.data() + read, &consumed, nullptr);
    used += written;
    read += consumed;
    if (LZ4F_isError(wanted) != 0)
      return {{}, std::string("the lz4 data are damaged (") + LZ4F_getErrorName(wanted) + ")"};
    if (wanted == 0) break;
    if (written == 0 && consumed == 0) {
      result.problem = "the lz4 data end early";
      break;
    }
  }
  result.bytes.resize(used);
  return result;
}

}  // namespace waymark::compression
