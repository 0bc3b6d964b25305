// SPDX-License-Identifier: Apache-2.0
// Images and clouds: what lies in memory as the message says.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "plugins/shared/cdr/conversions.hpp"

namespace waymark::ros {
namespace {

/// How an image's channels lie in memory.
struct PixelOrder {
  std::string_view name;
  std::size_t channels;
  std::array<std::size_t, 3> bgr;  ///< where blue, green, red are
};

constexpr std::array<PixelOrder, 8> kPixelOrders = {{{"mono8", 1, {}},
                                                     {"8UC1", 1, {}},
                                                     {"bgr8", 3, {0, 1, 2}},
                                                     {"8UC3", 3, {0, 1, 2}},
                                                     {"rgb8", 3, {2, 1, 0}},
                                                     {"bgra8", 4, {0, 1, 2}},
                                                     {"8UC4", 4, {0, 1, 2}},
                                                     {"rgba8", 4, {2, 1, 0}}}};

/// A number of every point of a cloud.
struct PointNumber {
  std::size_t offset = 0;
  std::uint8_t type = 0;  ///< of PointField; 0: there is none

  bool is_there() const { return type != 0; }
  bool is_whole() const { return type <= 6; }
};

/// A turn of a scanner takes 0.05 to 1 s; a time far from the stamp is none, or the stamp is not the clock's.
constexpr float kLongestSweep = 60.0f;

constexpr std::array<std::size_t, 9> kPointFieldSizes{0, 1, 1, 2, 2, 4, 4, 4, 8};

PointNumber find_number(const sensor_msgs::PointCloud2& cloud, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    const auto field = std::ranges::find(cloud.fields, name, &sensor_msgs::PointField::name);
    if (field == cloud.fields.end()) continue;
    const bool known = field->datatype > 0 && field->datatype < kPointFieldSizes.size();
    if (!known || field->offset + kPointFieldSizes.at(field->datatype) > cloud.point_step ||
        field->offset > (1U << 20)) {
      throw Unusable(fmt::format("the number \"{}\" of type {} at byte {} of a point is beyond its {} bytes", name,
                                 field->datatype, field->offset, cloud.point_step));
    }
    return {field->offset, field->datatype};
  }
  return {};
}

template <class T>
T number_at(const std::uint8_t* at, bool swapped) {
  std::array<std::uint8_t, sizeof(T)> raw{};
  std::memcpy(raw.data(), at, sizeof(T));
  if (swapped) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

double value_at(const PointNumber& number, const std::uint8_t* point, bool swapped) {
  const std::uint8_t* const at = point + number.offset;
  switch (number.type) {
    case 1:
      return number_at<std::int8_t>(at, swapped);
    case 2:
      return number_at<std::uint8_t>(at, swapped);
    case 3:
      return number_at<std::int16_t>(at, swapped);
    case 4:
      return number_at<std::uint16_t>(at, swapped);
    case 5:
      return number_at<std::int32_t>(at, swapped);
    case 6:
      return number_at<std::uint32_t>(at, swapped);
    case 7:
      return static_cast<double>(number_at<float>(at, swapped));
    default:
      return number_at<double>(at, swapped);
  }
}

/// Seconds after the stamp. Whole numbers are nanoseconds after it; others are seconds after it, seconds of the clock,
/// or its nanoseconds (Livox has these).
double offset_s(const PointNumber& number, double value, Time stamp) {
  constexpr double kYear_s = 3.2e7;
  if (number.is_whole()) return 1e-9 * value;
  if (value > 1e9 * kYear_s) return 1e-9 * (value - static_cast<double>(stamp.time_since_epoch().count()));
  return value > kYear_s ? value - to_seconds(stamp.time_since_epoch()) : value;
}

}  // namespace

std::shared_ptr<Image> to_image(const sensor_msgs::Image& message) {
  auto picture = std::make_shared<Image>();
  const std::size_t height = message.height;
  const std::size_t width = message.width;
  const std::size_t step = message.step;
  const Bytes data = message.data;
  const auto* const order = std::ranges::find(kPixelOrders, message.encoding, &PixelOrder::name);
  if (order == kPixelOrders.end()) {
    throw Unusable(
        fmt::format(R"(the encoding "{}" of an image is not supported; "bgr8", "rgb8" or "mono8" is expected)",
                    std::string_view(message.encoding).substr(0, 40)));
  }
  constexpr std::size_t kMost = 1 << 16;
  const bool fits = height > 0 && height <= kMost && width > 0 && width <= kMost && step >= width * order->channels &&
                    data.size() >= step * height;
  if (!fits) {
    throw Unusable(
        fmt::format("an image of {} x {} pixels in rows of {} bytes has {} bytes", width, height, step, data.size()));
  }
  picture->encoding = order->channels == 1 ? Image::Encoding::mono8 : Image::Encoding::bgr8;
  picture->width = static_cast<int>(width);
  picture->height = static_cast<int>(height);
  picture->data.reserve(width * height * std::min<std::size_t>(order->channels, 3));
  for (std::size_t row = 0; row < height; ++row) {
    const Bytes pixels = data.subspan(row * step, width * order->channels);
    if (order->channels == 1) {
      picture->data.insert(picture->data.end(), pixels.begin(), pixels.end());
      continue;
    }
    for (std::size_t i = 0; i < pixels.size(); i += order->channels) {
      for (const std::size_t channel : order->bgr) picture->data.push_back(pixels[i + channel]);
    }
  }
  return picture;
}

std::shared_ptr<Image> to_image(sensor_msgs::CompressedImage message) {
  auto picture = std::make_shared<Image>();
  picture->encoding = Image::Encoding::compressed;
  picture->data = std::move(message.data);
  return picture;
}

std::shared_ptr<PointCloud> to_point_cloud(const sensor_msgs::PointCloud2& message) {
  const std::size_t step = message.point_step;
  const std::size_t row_step = message.row_step;
  const std::size_t width = message.width;
  const std::size_t height = message.height;
  const bool fits =
      step > 0 && width <= message.data.size() / step &&
      (height <= 1 || (row_step > 0 && row_step >= width * step && height <= message.data.size() / row_step));
  if (!fits) {
    throw Unusable(fmt::format("a cloud of {} x {} points of {} bytes in rows of {} has {} bytes", width, height, step,
                               row_step, message.data.size()));
  }
  const std::array<PointNumber, 3> xyz{find_number(message, {"x"}), find_number(message, {"y"}),
                                       find_number(message, {"z"})};
  if (!std::ranges::all_of(xyz, &PointNumber::is_there)) throw Unusable("the points of a cloud have no x, y and z");
  const PointNumber intensity = find_number(message, {"intensity"});
  const PointNumber time = find_number(message, {"t", "time", "time_stamp", "timestamp", "offset_time"});
  const bool swapped = message.is_bigendian;
  const Time stamp = to_time(message.header.stamp).value_or(Time{});

  auto cloud = std::make_shared<PointCloud>();
  cloud->points_m.reserve(width * height);
  for (std::size_t row = 0; row < height; ++row) {
    for (std::size_t column = 0; column < width; ++column) {
      const std::uint8_t* const point = message.data.data() + row * row_step + column * step;
      Eigen::Vector3f p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = static_cast<float>(value_at(xyz.at(static_cast<std::size_t>(axis)), point, swapped));
      if (!p.allFinite()) continue;
      cloud->points_m.push_back(p);
      if (intensity.is_there()) cloud->intensities.push_back(static_cast<float>(value_at(intensity, point, swapped)));
      if (!time.is_there()) continue;
      const auto offset = static_cast<float>(offset_s(time, value_at(time, point, swapped), stamp));
      if (!(std::abs(offset) <= kLongestSweep)) {
        throw Unusable(fmt::format("a point was measured {} s after the stamp of its cloud; at most {} s are expected",
                                   offset, kLongestSweep));
      }
      cloud->offsets_s.push_back(offset);
    }
  }
  for (float& value : cloud->intensities) {
    if (std::isinf(value)) value = std::numeric_limits<float>::quiet_NaN();
  }
  return cloud;
}

}  // namespace waymark::ros
