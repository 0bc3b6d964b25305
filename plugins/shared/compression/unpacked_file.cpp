// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/compression/unpacked_file.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark::compression {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 18;
/// No recording is packed to less than a thousandth; gzip could not do it at all.
constexpr std::uintmax_t kMostTimes = 1000;
constexpr std::uintmax_t kAlways = std::uintmax_t{1} << 24;

/// A new temporary file that is written from its start, for what `packed` holds.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path packed)
      : packed_(std::move(packed)), path_((std::filesystem::temp_directory_path() / "waymark_XXXXXX").string()) {
    std::error_code ignored;
    const std::uintmax_t size = std::filesystem::file_size(packed_, ignored);
    if (!ignored) most_ += kMostTimes * size;
    descriptor_ = ::mkstemp(path_.data());
    if (descriptor_ < 0) throw DataError(path_ + ": cannot be created: " + std::strerror(errno));
  }
  ~TemporaryFile() {
    ::close(descriptor_);
    if (!kept_) ::unlink(path_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  void append(std::span<const std::uint8_t> bytes) {
    size_ += bytes.size();
    if (size_ > most_) {
      throw DataError(fmt::format("{}: unpacks to more than {} times its size, which no recording does",
                                  packed_.string(), kMostTimes));
    }
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t written = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
      if (written < 0 && errno != EINTR) throw DataError(path_ + ": cannot be written: " + std::strerror(errno));
      if (written > 0) done += static_cast<std::size_t>(written);
    }
  }
  std::filesystem::path keep() {
    kept_ = true;
    return path_;
  }

 private:
  std::filesystem::path packed_;
  std::uintmax_t most_ = kAlways;  // bytes
  std::uintmax_t size_ = 0;
  std::string path_;
  int descriptor_ = -1;
  bool kept_ = false;
};

void unpack_gzip(const std::filesystem::path& file, TemporaryFile& out) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(::gzopen(file.c_str(), "rb"), ::gzclose);
  if (!in) throw DataError(file.string() + ": cannot be read: " + std::strerror(errno));
  std::vector<std::uint8_t> piece(kPiece);
  for (int got = 1; got > 0;) {
    got = ::gzread(in.get(), piece.data(), static_cast<unsigned>(piece.size()));
    if (got > 0) out.append({piece.data(), static_cast<std::size_t>(got)});
  }
  int status = Z_OK;
  const std::string reason = ::gzerror(in.get(), &status);
  if (status != Z_OK && status != Z_STREAM_END) throw DataError(file.string() + ": is damaged: " + reason);
}

struct FreeDecompressor {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

void unpack_zstd(const std::filesystem::path& file, TemporaryFile& out) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw DataError(file.string() + ": cannot be read: " + std::strerror(errno));
  const std::unique_ptr<ZSTD_DCtx, FreeDecompressor> context(ZSTD_createDCtx());
  if (!context) throw std::bad_alloc();
  std::vector<char> packed(kPiece);
  std::vector<std::uint8_t> piece(kPiece);
  std::size_t wanted = 0;
  while (in.read(packed.data(), static_cast<std::streamsize>(packed.size())) || in.gcount() > 0) {
    ZSTD_inBuffer source{packed.data(), static_cast<std::size_t>(in.gcount()), 0};
    bool is_full = true;
    while (source.pos < source.size || is_full) {
      ZSTD_outBuffer target{piece.data(), piece.size(), 0};
      wanted = ZSTD_decompressStream(context.get(), &target, &source);
      if (ZSTD_isError(wanted) != 0) throw DataError(file.string() + ": is damaged: " + ZSTD_getErrorName(wanted));
      out.append({piece.data(), target.pos});
      is_full = target.pos == target.size;
      if (target.pos == 0 && source.pos == source.size) break;
    }
  }
  if (wanted != 0) throw DataError(file.string() + ": is damaged: it ends early");
}

}  // namespace

UnpackedFile::UnpackedFile(std::filesystem::path file) : file_(std::move(file)) {
  const std::filesystem::path extension = file_.extension();
  if (extension != ".gz" && extension != ".zst" && extension != ".zstd") return;
  TemporaryFile out(file_);
  extension == ".gz" ? unpack_gzip(file_, out) : unpack_zstd(file_, out);
  temporary_ = out.keep();
}

UnpackedFile::~UnpackedFile() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

UnpackedFile::UnpackedFile(UnpackedFile&& other) noexcept
    : file_(std::move(other.file_)), temporary_(std::exchange(other.temporary_, {})) {}

}  // namespace waymark::compression
