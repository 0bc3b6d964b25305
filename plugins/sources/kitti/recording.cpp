// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>

#include "timestamps.hpp"
#include "unusable.hpp"
#include "waymark/base/error.hpp"

namespace waymark::kitti {
namespace {

static_assert(std::endian::native == std::endian::little, "the recording's floats are little-endian");

/// The number in "0000000012.bin.gz", if the rest of the name is `ending`.
std::optional<std::uint64_t> frame_of(const std::string& name, const std::string& ending) {
  if (!name.ends_with(ending)) return std::nullopt;
  std::uint64_t number = 0;
  const char* end = name.data() + name.size() - ending.size();
  const auto [rest, error] = std::from_chars(name.data(), end, number);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return number;
}

constexpr std::size_t kMostBytes = std::size_t{1} << 28;  // a turn of the scanner has two million, an image fewer

struct CloseGzip {
  void operator()(gzFile file) const { gzclose(file); }
};

std::vector<std::uint8_t> inflate(const std::filesystem::path& file) {
  constexpr unsigned kChunk = 1 << 20;
  const std::string place = file.string();
  errno = 0;
  const std::unique_ptr<gzFile_s, CloseGzip> in(gzopen(file.c_str(), "rb"));
  if (!in) throw Unusable(place, fmt::format("cannot be read: {}", std::strerror(errno)));
  std::vector<std::uint8_t> bytes;
  std::size_t end = 0;
  for (int count = 1; count > 0; end += static_cast<std::size_t>(std::max(count, 0))) {
    if (end > kMostBytes) throw Unusable(place, "is far too long for one turn of a scanner");
    bytes.resize(end + kChunk);
    count = gzread(in.get(), bytes.data() + end, kChunk);
  }
  int status = Z_OK;
  const char* words = gzerror(in.get(), &status);
  if (status == Z_BUF_ERROR) throw Unusable(place, "the gzip stream ends early");
  if (status == Z_ERRNO) throw Unusable(place, fmt::format("cannot be read: {}", std::strerror(errno)));
  if (status != Z_OK) throw Unusable(place, fmt::format("the gzip stream is damaged: {}", words));
  if (end == 0) throw Unusable(place, "is empty");
  bytes.resize(end);
  return bytes;
}

}  // namespace

Stream::Stream(const std::filesystem::path& folder, const std::vector<std::string>& endings)
    : folder_(folder), ending_(endings.front()) {
  const std::filesystem::path data = folder / "data";
  std::error_code failure;
  std::filesystem::directory_iterator entries(data, failure);
  if (failure) throw DataError(fmt::format("{}: no such folder: {}", data.string(), failure.message()));
  std::map<std::uint64_t, std::size_t> rank;
  for (const auto& entry : entries) {
    for (std::size_t i = 0; i < endings.size(); ++i) {
      const auto frame = frame_of(entry.path().filename().string(), endings[i]);
      if (!frame || (rank.contains(*frame) && rank[*frame] < i)) continue;
      rank[*frame] = i;
      files_[*frame] = entry.path();
    }
  }
  if (files_.empty()) {
    throw DataError(fmt::format("{}: holds no file <number>{}", data.string(), fmt::join(endings, " or <number>")));
  }
  if (std::filesystem::exists(stamps_file())) stamps_ = read_timestamps(stamps_file());
}

std::filesystem::path Stream::expected(std::uint64_t frame) const {
  return folder_ / "data" / fmt::format("{:010}{}", frame, ending_);
}

std::optional<Time> Stream::stamp(std::uint64_t frame) const {
  if (!stamps_ || frame >= stamps_->size()) return std::nullopt;
  return (*stamps_)[frame];
}

std::vector<Entry> schedule(const std::vector<StampRule>& streams, Duration period) {
  std::set<std::uint64_t> frames;
  for (const StampRule& rule : streams) {
    for (const auto& [frame, file] : rule.stream->files()) frames.insert(frame);
  }
  std::vector<Entry> entries;
  for (std::uint32_t i = 0; i < streams.size(); ++i) {
    const Stream* const stream = streams[i].stream;
    const Stream* const stamps = streams[i].stamps;
    std::optional<Time> newest;
    for (const std::uint64_t frame : frames) {
      Entry entry{newest.value_or(Time{}), i, stream->expected(frame), {}};
      const auto file = stream->files().find(frame);
      if (file == stream->files().end()) {
        entry.problem = "is missing; there is a frame of this number";
      } else {
        entry.file = file->second;
      }
      const auto stamp = stamps->has_stamps() ? stamps->stamp(frame) : stamp_after(frame, period);
      const auto place = [&] { return fmt::format("{}:{}", stamps->stamps_file().string(), frame + 1); };
      if (!stamp && !stamps->has_stamps()) {
        entry.problem = "has no stamp: its number times frame_period_s is more than 146 years";
      } else if (!stamp) {
        entry.problem = fmt::format("has no stamp: {} ends before", place());
      } else if (newest && *stamp <= *newest) {
        entry.problem = fmt::format("its stamp is not later than the one before: {}", place());
      } else {
        newest = entry.stamp = *stamp;
      }
      entries.push_back(std::move(entry));
    }
  }
  std::ranges::stable_sort(entries, {}, &Entry::stamp);
  return entries;
}

void read_points(const std::filesystem::path& file, std::vector<float>& values) {
  constexpr std::size_t kPoint = 4 * sizeof(float);
  // What gzip looks like is also how a first point may look, so the ending decides.
  const std::vector<std::uint8_t> bytes = file.extension() == ".gz" ? inflate(file) : read_bytes(file);
  if (bytes.size() % kPoint != 0) {
    throw Unusable(file.string(),
                   fmt::format("{} bytes are not a whole number of points of {} bytes", bytes.size(), kPoint));
  }
  values.resize(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), bytes.size());
}

std::size_t take_points(std::span<const float> points, std::size_t every, PointCloud& cloud) {
  constexpr std::size_t kFloats = 4;
  std::size_t not_finite = 0;
  const std::size_t count = points.size() / kFloats;
  cloud.points_m.reserve(count / every + 1);
  cloud.intensities.reserve(count / every + 1);
  for (std::size_t i = 0; i < count; i += every) {
    const float* const at = points.data() + kFloats * i;
    const Eigen::Vector3f p(at[0], at[1], at[2]);
    if (!p.allFinite() || !std::isfinite(at[3])) {
      ++not_finite;
      continue;
    }
    cloud.points_m.push_back(p);
    cloud.intensities.push_back(at[3]);
  }
  return not_finite;
}

std::vector<std::uint8_t> read_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Unusable(file.string(), "cannot be read");
  // Block by block: the length of a folder is not a length, and an iterator over its buffer throws what is not an error
  // of ours.
  std::vector<std::uint8_t> bytes;
  std::array<char, 65536> block{};
  while (in.read(block.data(), block.size()) || in.gcount() > 0) {
    bytes.insert(bytes.end(), block.begin(), block.begin() + in.gcount());
    if (bytes.size() > kMostBytes) throw Unusable(file.string(), "is larger than 256 MiB");
  }
  if (in.bad()) throw Unusable(file.string(), "cannot be read on");
  if (bytes.empty()) throw Unusable(file.string(), "is empty");
  return bytes;
}

}  // namespace waymark::kitti
