// SPDX-License-Identifier: Apache-2.0
#include "targets_file.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "bytes_file.hpp"
#include "points_text.hpp"
#include "waymark/base/error.hpp"

namespace waymark::radar {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");

/// The number at `offset` of packed bytes.
template <class T>
T number_at(const std::uint8_t* bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes + offset, sizeof value);
  return value;
}

/// RADT0001: range [cm] u2, azimuth [1e-4 rad] i2, radial velocity [1/250 m/s] i2, cross-section [0.01 dB] i2, label
/// u1.
struct PolarRecord {
  static constexpr std::string_view kMagic = "RADT0001";
  static constexpr std::size_t kBytes = 9;

  static void append(const std::uint8_t* r, Scan& scan) {
    RadarTargets::One& one = scan.targets.emplace_back();
    one.range_m = 0.01 * number_at<std::uint16_t>(r, 0);
    one.azimuth_rad = 1e-4 * number_at<std::int16_t>(r, 2);
    one.radial_mps = number_at<std::int16_t>(r, 4) / 250.0;
    one.rcs_dbsm = 0.01 * number_at<std::int16_t>(r, 6);
    scan.labels.push_back(r[8]);
  }
};

/// RADC0001: x, y [cm] i2, v_x, v_y [cm/s] i2, cross-section [0.5 dBsm] i1, dynamic property, ambiguity, validity u1.
struct CartesianRecord {
  static constexpr std::string_view kMagic = "RADC0001";
  static constexpr std::size_t kBytes = 12;
  static constexpr std::uint8_t kUnambiguous = 3;
  static constexpr std::uint8_t kValid = 0;

  static void append(const std::uint8_t* r, Scan& scan) {
    if (r[10] != kUnambiguous || r[11] != kValid) return;
    const double x = 0.01 * number_at<std::int16_t>(r, 0);
    const double y = 0.01 * number_at<std::int16_t>(r, 2);
    const double range = std::hypot(x, y);
    if (range == 0.0) return;  // at the radar itself: no direction
    RadarTargets::One& one = scan.targets.emplace_back();
    one.range_m = range;
    one.azimuth_rad = std::atan2(y, x);
    one.radial_mps = 0.01 * (x * number_at<std::int16_t>(r, 4) + y * number_at<std::int16_t>(r, 6)) / range;
    one.rcs_dbsm = 0.5 * number_at<std::int8_t>(r, 8);
    scan.labels.push_back(r[9]);
  }
};

/// Behind the magic the number of scans (u4); of each time [s] (f8), radar (u2) and number of records (u2).
template <class Record>
class BinaryFile final : public TargetsFile {
 public:
  explicit BinaryFile(std::unique_ptr<BytesFile> file) : file_(std::move(file)) {
    std::array<std::uint8_t, 4> count{};
    take(count.data(), count.size());
    scans_ = number_at<std::uint32_t>(count.data(), 0);
  }

  double progress() const override {
    return scans_ == 0 ? 1.0 : static_cast<double>(done_) / static_cast<double>(scans_);
  }

 protected:
  std::optional<Scan> read() override {
    if (done_ == scans_) {
      std::uint8_t more = 0;
      if (file_->read(&more, 1) != 0) {
        throw DataError(file_->name() + ": there are other bytes after the last of " + std::to_string(scans_) +
                        " scans");
      }
      return std::nullopt;
    }
    std::array<std::uint8_t, 12> head{};
    take(head.data(), head.size());
    const auto t = number_at<double>(head.data(), 0);
    if (!(std::abs(t) < to_seconds(kLongest))) throw DataError(place() + ": its time is no time in seconds");
    Scan scan;
    scan.stamp = Time(from_seconds(t));
    scan.radar = number_at<std::uint16_t>(head.data(), 8);
    const std::size_t records = number_at<std::uint16_t>(head.data(), 10);
    bytes_.resize(records * Record::kBytes);
    take(bytes_.data(), bytes_.size());
    scan.targets.reserve(records);
    scan.labels.reserve(records);
    for (std::size_t i = 0; i < records; ++i) Record::append(bytes_.data() + i * Record::kBytes, scan);
    ++done_;
    return scan;
  }
  std::string place() const override { return file_->name() + ": scan " + std::to_string(done_); }

 private:
  void take(std::uint8_t* data, std::size_t size) {
    if (file_->read(data, size) == size) return;
    throw DataError(place() + ": the file ends early; " + std::to_string(scans_) + " scans are expected");
  }

  std::unique_ptr<BytesFile> file_;
  std::uint32_t scans_ = 0;
  std::uint32_t done_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

std::unique_ptr<TargetsFile> TargetsFile::open(const std::filesystem::path& file) {
  auto bytes = std::make_unique<BytesFile>(file);
  std::array<char, 8> magic{};
  const std::string_view start(magic.data(), bytes->read(magic.data(), magic.size()));
  if (start == PolarRecord::kMagic) return std::make_unique<BinaryFile<PolarRecord>>(std::move(bytes));
  if (start == CartesianRecord::kMagic) return std::make_unique<BinaryFile<CartesianRecord>>(std::move(bytes));
  bytes->rewind();
  return std::make_unique<PointsText>(std::move(bytes));
}

std::optional<Scan> TargetsFile::next() {
  std::optional<Scan> scan = read();
  if (!scan) return scan;
  if (last_ && scan->stamp < *last_) {
    throw DataError(place() + ": time goes back from " + format_time(*last_) + " to " + format_time(scan->stamp) +
                    " s; scans in order are expected");
  }
  last_ = scan->stamp;
  return scan;
}

}  // namespace waymark::radar
