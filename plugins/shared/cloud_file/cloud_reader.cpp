// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cloud_file/cloud_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "waymark/base/error.hpp"

namespace waymark::cloud_file {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 16;

template <class T>
T number_at(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// A float64 stands for the shortest decimal number that is read as it: 1630577758.56949 s are 1630577758569490000 ns,
/// as the text has it that it was written from.
std::optional<Time> stamp_of(double seconds) {
  if (!std::isfinite(seconds)) return std::nullopt;
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), seconds);
  try {
    return parse_time({text.data(), static_cast<std::size_t>(end.ptr - text.data())});
  } catch (const DataError&) {
    return std::nullopt;
  }
}

/// Which points of a cloud are taken: of every n-th one, so many, evenly.
class Selection {
 public:
  Selection(const Thinning& thinning, std::uint32_t points)
      : every_(std::max(thinning.every, 1U)),
        candidates_((std::uint64_t{points} + every_ - 1) / every_),
        taken_(std::min<std::uint64_t>(candidates_, thinning.at_most)) {}

  std::uint64_t size() const { return taken_; }
  /// To be asked for each point in turn.
  bool next() {
    const std::uint64_t point = point_++;
    if (point % every_ != 0) return false;
    const std::uint64_t candidate = point / every_;
    return candidate == 0 ? taken_ > 0 : candidate * taken_ / candidates_ != (candidate - 1) * taken_ / candidates_;
  }

 private:
  std::uint64_t every_;
  std::uint64_t candidates_;
  std::uint64_t taken_;
  std::uint64_t point_ = 0;
};

}  // namespace

CloudReader::CloudReader(const std::filesystem::path& file)
    : name_(file.string()), bytes_(file), buffer_(kBufferBytes) {
  std::array<char, 8> version{};
  std::size_t filled = 0;
  while (filled < version.size()) {
    const std::size_t count = bytes_.read(version.data() + filled, version.size() - filled);
    if (count == 0) break;
    filled += count;
  }
  const std::string_view found(version.data(), filled);
  is_compact_ = found == kCompact;
  if (!is_compact_ && found != kFull) {
    if (!bytes_.problem().empty()) fail(std::string(bytes_.problem()));
    if (found.starts_with("SCN2")) {
      throw DataError(name_ +
                      ": holds planar scans (SCN2…), no clouds; the source csv reads such ones, see its key records");
    }
    throw DataError(fmt::format("{}: is no file of clouds: it does not begin with {} or {}", name_, kCompact, kFull));
  }
  std::array<char, 4> number;
  fill(number.data(), number.size(), "head of the file");
  clouds_ = number_at<std::uint32_t>(number.data());
  if (!is_compact_) {
    fill(number.data(), number.size(), "head of the file");
    has_ = number_at<std::uint32_t>(number.data());
    if ((has_ & ~(kHasIntensities | kHasTimes)) != 0)
      throw DataError(fmt::format("{}: its points have numbers of an unknown kind ({:#x}); at most {:#x} is expected",
                                  name_, has_, kHasIntensities | kHasTimes));
  }
  point_bytes_ = is_compact_ ? 3 * sizeof(std::int16_t)
                             : sizeof(float) * (3 + (has_intensities() ? 1U : 0U) + (has_times() ? 1U : 0U));
  if (clouds_ > bytes_.most_left() / kHeadBytes)
    throw DataError(fmt::format("{}: states {} clouds, more than it can hold", name_, clouds_));
}

std::string CloudReader::place() const { return fmt::format("{}:cloud {}", name_, next_ == 0 ? 0 : next_ - 1); }

double CloudReader::progress() const {
  const auto size = static_cast<double>(bytes_.file_size());
  return size > 0.0 ? std::min(static_cast<double>(bytes_.consumed()) / size, 1.0) : 0.0;
}

void CloudReader::fail(const std::string& problem) const {
  throw DataError(fmt::format("{} (byte {}): {}", place(), bytes_.produced(), problem));
}

void CloudReader::fill(char* data, std::size_t size, std::string_view what) {
  for (std::size_t filled = 0; filled < size;) {
    const std::size_t count = bytes_.read(data + filled, size - filled);
    if (count == 0) {
      fail(bytes_.problem().empty() ? fmt::format("the file ends within the {}", what) : std::string(bytes_.problem()));
    }
    filled += count;
  }
}

void CloudReader::pass_over() {
  while (unread_ > 0) {
    const auto points = static_cast<std::uint32_t>(std::min<std::size_t>(unread_, buffer_.size() / point_bytes_));
    fill(buffer_.data(), points * point_bytes_, "points");
    unread_ -= points;
  }
}

std::optional<CloudReader::Head> CloudReader::next() {
  pass_over();
  if (next_ == clouds_) {
    if (bytes_.read(buffer_.data(), 1) > 0)
      fail(fmt::format("the file goes on behind the last of the {} clouds that it states", clouds_));
    if (!bytes_.problem().empty()) fail(std::string(bytes_.problem()));
    return std::nullopt;
  }
  Head head;
  head.number = next_++;
  std::array<char, kHeadBytes> bytes;
  fill(bytes.data(), bytes.size(), "head of a cloud");
  if (is_compact_) {
    head.stamp = stamp_of(number_at<double>(bytes.data()));
  } else {
    const Time stamp{Duration{number_at<std::int64_t>(bytes.data())}};
    if (is_stamp(stamp)) head.stamp = stamp;
  }
  head.points = number_at<std::uint32_t>(bytes.data() + sizeof(std::int64_t));
  if (head.points > kMostPoints)
    fail(fmt::format("states {} points; at most {} are expected", head.points, kMostPoints));
  if (head.points > bytes_.most_left() / point_bytes_)
    fail(fmt::format("states {} points, more than the rest of the file can hold", head.points));
  unread_ = head.points;
  return head;
}

std::size_t CloudReader::read(const Thinning& thinning, PointCloud& cloud) {
  Selection selection(thinning, unread_);
  const std::size_t most = buffer_.size() / point_bytes_;
  std::size_t not_finite = 0;
  cloud.points_m.clear();
  cloud.intensities.clear();
  cloud.offsets_s.clear();
  // Not more at once than a small file may hold; a large one grows.
  constexpr std::uint64_t kFirst = std::uint64_t{1} << 18;
  cloud.points_m.reserve(std::min(selection.size(), kFirst));
  while (unread_ > 0) {
    const auto points = static_cast<std::uint32_t>(std::min<std::size_t>(unread_, most));
    fill(buffer_.data(), points * point_bytes_, "points");
    unread_ -= points;
    for (const char* at = buffer_.data(); at != buffer_.data() + points * point_bytes_; at += point_bytes_) {
      if (!selection.next()) continue;
      if (is_compact_) {
        constexpr auto kUnit_m = static_cast<float>(kCompactUnit);
        cloud.points_m.emplace_back(kUnit_m * static_cast<float>(number_at<std::int16_t>(at)),
                                    kUnit_m * static_cast<float>(number_at<std::int16_t>(at + 2)),
                                    kUnit_m * static_cast<float>(number_at<std::int16_t>(at + 4)));
        continue;
      }
      const char* field = at;
      const auto take = [&field] {
        const auto value = number_at<float>(field);
        field += sizeof(float);
        return value;
      };
      Eigen::Vector3f p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = take();
      const float intensity = has_intensities() ? take() : 0.0f;
      const float offset = has_times() ? take() : 0.0f;
      if (!p.allFinite() || !std::isfinite(offset)) {
        ++not_finite;
        continue;
      }
      cloud.points_m.push_back(p);
      // NaN is an unknown intensity; infinity is none.
      if (has_intensities())
        cloud.intensities.push_back(std::isfinite(intensity) ? intensity : std::numeric_limits<float>::quiet_NaN());
      if (has_times()) cloud.offsets_s.push_back(offset);
    }
  }
  return not_finite;
}

}  // namespace waymark::cloud_file
