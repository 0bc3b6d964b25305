// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cloud_file/cloud_writer.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <new>
#include <string_view>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::cloud_file {
namespace {

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

class CloudWriter::Deflater {
 public:
  Deflater() {
    constexpr int kGzip = 15 + 16;  // the largest window, with gzip's framing
    constexpr int kMemory = 8;
    if (deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::bad_alloc();
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void write(std::string_view bytes, int flush, OutputFile& out) {
    std::array<char, 1 << 16> piece;
    while (true) {
      // avail_in has 32 bits.
      const std::string_view part = bytes.substr(0, std::size_t{1} << 30);
      bytes.remove_prefix(part.size());
      // zlib does not write to its input, but its interface does not say so.
      stream_.next_in =
          reinterpret_cast<Bytef*>(const_cast<char*>(part.data()));  // NOLINT(cppcoreguidelines-pro-type-const-cast)
      stream_.avail_in = static_cast<uInt>(part.size());
      do {
        stream_.next_out = reinterpret_cast<Bytef*>(piece.data());
        stream_.avail_out = static_cast<uInt>(piece.size());
        deflate(&stream_, bytes.empty() ? flush : Z_NO_FLUSH);
        out.write({piece.data(), piece.size() - stream_.avail_out});
      } while (stream_.avail_out == 0);
      if (bytes.empty()) return;
    }
  }

 private:
  z_stream stream_{};
};

CloudWriter::CloudWriter(const std::filesystem::path& file, const Contents& contents)
    : name_(file.string()), contents_(contents), out_(file) {
  if (file.extension() == ".gz") deflater_ = std::make_unique<Deflater>();
  bytes_ = kFull;
  append(bytes_, contents_.clouds);
  append(bytes_, (contents_.intensities ? kHasIntensities : 0U) | (contents_.times ? kHasTimes : 0U));
  write(bytes_);
}

CloudWriter::~CloudWriter() = default;

void CloudWriter::write(std::string_view bytes) {
  deflater_ ? deflater_->write(bytes, Z_NO_FLUSH, out_) : out_.write(bytes);
}

void CloudWriter::add(Time stamp, const PointCloud& cloud) {
  const std::size_t points = cloud.points_m.size();
  const auto fail = [&](const std::string& problem) {
    throw DataError(fmt::format("{}: cloud {}: {}", name_, written_, problem));
  };
  if (written_ == contents_.clouds) fail(fmt::format("is one more than the {} that were stated", contents_.clouds));
  if (!is_stamp(stamp)) fail("its time is no stamp; the years 1824 to 2115 are");
  if (stamp <= newest_) {
    fail(fmt::format("its time, {}, is not later than that of the cloud before, {}", format_time(stamp),
                     format_time(newest_)));
  }
  if (points > kMostPoints) fail(fmt::format("has {} points; at most {} are expected", points, kMostPoints));
  if (cloud.intensities.size() != (contents_.intensities ? points : 0))
    fail(fmt::format("{} points have {} intensities", points, cloud.intensities.size()));
  if (cloud.offsets_s.size() != (contents_.times ? points : 0))
    fail(fmt::format("{} points have {} times", points, cloud.offsets_s.size()));
  bytes_.clear();
  append(bytes_, std::int64_t{stamp.time_since_epoch().count()});
  append(bytes_, static_cast<std::uint32_t>(points));
  for (std::size_t i = 0; i < points; ++i) {
    for (int axis = 0; axis < 3; ++axis) append(bytes_, cloud.points_m[i][axis]);
    if (contents_.intensities) append(bytes_, cloud.intensities[i]);
    if (contents_.times) append(bytes_, cloud.offsets_s[i]);
  }
  write(bytes_);
  newest_ = stamp;
  ++written_;
}

void CloudWriter::finish() {
  if (written_ != contents_.clouds)
    throw DataError(fmt::format("{}: has {} clouds; {} were stated", name_, written_, contents_.clouds));
  if (deflater_) deflater_->write({}, Z_FINISH, out_);
  out_.commit();
}

}  // namespace waymark::cloud_file
