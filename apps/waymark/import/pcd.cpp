// SPDX-License-Identifier: Apache-2.0
// PCD, version 0.7 (pointclouds.org/documentation/tutorials/pcd_file_format.html).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include "apps/waymark/import/lzf.hpp"
#include "apps/waymark/import/point_file.hpp"
#include "plugins/shared/cloud_file/cloud_layout.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {
namespace {

static_assert(std::endian::native == std::endian::little, "binary PCD is little-endian");

struct Field {
  std::string name;
  std::size_t size = 4;
  char type = 'F';  ///< I, U or F
  std::size_t count = 1;

  std::size_t bytes() const { return size * count; }
};

struct Head {
  std::vector<Field> fields;
  std::uint64_t points = 0;
  std::string data;     ///< ascii, binary or binary_compressed
  std::size_t end = 0;  ///< byte behind the head
  std::size_t lines = 0;
  bool has_viewpoint = false;  ///< another one than the origin

  std::size_t point_bytes() const {
    std::size_t sum = 0;
    for (const Field& field : fields) sum += field.bytes();
    return sum;
  }
};

/// Reads the head line by line; messages name the line.
class HeadReader {
 public:
  HeadReader(std::string_view content, const std::string& name) : content_(content), name_(name) {}

  Head read();

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw DataError(fmt::format("{}:{}: {}", name_, head_.lines, problem));
  }
  std::uint64_t whole(const std::string& word, std::uint64_t most) const {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || value > most)
      fail(fmt::format("\"{}\" is no whole number up to {}", word.substr(0, 40), most));
    return value;
  }
  void take(const std::string& key, const std::vector<std::string>& words);
  void check();

  std::string_view content_;
  const std::string& name_;
  Head head_;
  std::optional<std::uint64_t> width_, height_, points_;
};

void HeadReader::take(const std::string& key, const std::vector<std::string>& words) {
  const auto one = [&] {
    if (words.size() != 1) fail(fmt::format("{} has {} words; one is expected", key, words.size()));
    return words.front();
  };
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (key == "FIELDS") {
    if (words.size() > 1000) fail("more than 1000 fields");
    for (const std::string& word : words) head_.fields.push_back({.name = word});
  } else if (key == "SIZE" || key == "TYPE" || key == "COUNT") {
    if (words.size() != head_.fields.size())
      fail(fmt::format("{} has {} words; there are {} fields", key, words.size(), head_.fields.size()));
    for (std::size_t i = 0; i < words.size(); ++i) {
      Field& field = head_.fields[i];
      if (key == "SIZE") field.size = whole(words[i], 8);
      if (key == "COUNT") field.count = whole(words[i], 1U << 16);
      if (key == "TYPE") field.type = words[i].size() == 1 ? words[i].front() : '?';
    }
  } else if (key == "WIDTH") {
    width_ = whole(one(), kMost);
  } else if (key == "HEIGHT") {
    height_ = whole(one(), kMost);
  } else if (key == "POINTS") {
    points_ = whole(one(), kMost);
  } else if (key == "VIEWPOINT") {
    const std::vector<std::string> origin{"0", "0", "0", "1", "0", "0", "0"};
    head_.has_viewpoint = words != origin;
  } else if (key == "DATA") {
    head_.data = one();
    if (head_.data != "ascii" && head_.data != "binary" && head_.data != "binary_compressed")
      fail(fmt::format("DATA \"{}\" is not one of: ascii, binary, binary_compressed", head_.data.substr(0, 40)));
  } else if (key != "VERSION") {
    fail(fmt::format("\"{}\" is no word of the head of a PCD", key.substr(0, 40)));
  }
}

void HeadReader::check() {
  if (!points_ && (!width_ || !height_)) fail("neither POINTS nor WIDTH and HEIGHT are given");
  head_.points = points_.value_or(0);
  if (width_ && height_) {
    const std::uint64_t product = *width_ * *height_;  // of two numbers of 32 bits
    if (points_ && product != *points_)
      fail(fmt::format("{} x {} points are not the {} of POINTS", *width_, *height_, *points_));
    head_.points = product;
  }
  if (head_.points > cloud_file::kMostPoints)
    fail(fmt::format("states {} points; at most {} are expected", head_.points, cloud_file::kMostPoints));
  for (const Field& field : head_.fields) {
    const bool is_number = field.type == 'F'                        ? field.size == 4 || field.size == 8
                           : field.type == 'I' || field.type == 'U' ? std::has_single_bit(field.size)
                                                                    : false;
    if (!is_number)
      fail(fmt::format("the field {} of TYPE {} and SIZE {} is no number", field.name, field.type, field.size));
  }
}

Head HeadReader::read() {
  std::size_t at = 0;
  while (head_.data.empty()) {
    ++head_.lines;
    const std::size_t end = content_.find('\n', at);
    constexpr std::size_t kLongest = 1 << 16;
    if (end == std::string_view::npos || end - at > kLongest || head_.lines > 1000)
      fail("is no PCD: there is no line DATA");
    std::istringstream line{std::string(content_.substr(at, end - at))};
    at = end + 1;
    std::string key;
    if (!(line >> key) || key.starts_with('#')) continue;
    std::vector<std::string> words;
    for (std::string word; line >> word;) words.push_back(word);
    take(key, words);
  }
  check();
  head_.end = at;
  return std::move(head_);
}

double number_at(const char* at, char type, std::size_t size) {
  const auto as = [at]<class T>(T value) {
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
  };
  switch (size) {
    case 1:
      return type == 'I' ? as(std::int8_t{}) : as(std::uint8_t{});
    case 2:
      return type == 'I' ? as(std::int16_t{}) : as(std::uint16_t{});
    case 4:
      return type == 'F' ? as(float{}) : type == 'I' ? as(std::int32_t{}) : as(std::uint32_t{});
    default:
      return type == 'F' ? as(double{}) : type == 'I' ? as(std::int64_t{}) : as(std::uint64_t{});
  }
}

/// The fields that are taken: indices; -1 if there is no such field.
struct Taken {
  std::array<int, 3> xyz{-1, -1, -1};
  int intensity = -1;
  int time = -1;
};

Taken find_fields(const Head& head, const std::string& name) {
  Taken taken;
  for (std::size_t i = 0; i < head.fields.size(); ++i) {
    const Field& field = head.fields[i];
    const auto index = static_cast<int>(i);
    if (field.count == 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (field.name == std::string_view("xyz").substr(axis, 1)) taken.xyz.at(axis) = index;
    }
    if (field.name == "intensity") taken.intensity = index;
    if (taken.time < 0 && is_time_of_point(field.name)) taken.time = index;
  }
  if (std::ranges::any_of(taken.xyz, [](int i) { return i < 0; }))
    throw DataError(fmt::format("{}: its FIELDS have no x, y and z", name));
  return taken;
}

/// Calls `point(number)` for each point, where number(i) is the first number of field i.
template <class Point>
void each_of_text(std::string_view content, const Head& head, const std::string& name, const Point& point) {
  std::size_t at = head.end;
  std::size_t line_number = head.lines;
  std::uint64_t points = 0;
  std::vector<double> numbers(head.fields.size());
  while (at < content.size()) {
    const std::size_t end = std::min(content.find('\n', at), content.size());
    std::string_view line = content.substr(at, end - at);
    at = end + 1;
    ++line_number;
    const auto fail = [&](const std::string& problem) {
      throw DataError(fmt::format("{}:{}: {}", name, line_number, problem));
    };
    const auto next_word = [&line]() -> std::string_view {
      line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
      const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
      line.remove_prefix(word.size());
      return word;
    };
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    if (++points > head.points) fail(fmt::format("is one more than the {} points that are stated", head.points));
    for (std::size_t i = 0; i < head.fields.size(); ++i) {
      for (std::size_t k = 0; k < head.fields[i].count; ++k) {
        const std::string_view word = next_word();
        double value = 0.0;
        const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || stop != word.data() + word.size())
          fail(fmt::format("\"{}\" is no number of the field {}", word.substr(0, 40), head.fields[i].name));
        if (k == 0) numbers[i] = value;
      }
    }
    point([&numbers](int i) { return numbers[static_cast<std::size_t>(i)]; });
  }
  if (points < head.points)
    throw DataError(fmt::format("{}: ends after {} of its {} points", name, points, head.points));
}

template <class Point>
void each_of_bytes(std::string_view content, const Head& head, const std::string& name, const Point& point) {
  const std::uint64_t size = head.points * head.point_bytes();  // at most 2^24 times 2^36
  std::string_view data = content.substr(head.end);
  std::string unpacked;
  const bool is_packed = head.data == "binary_compressed";
  if (is_packed) {
    std::array<std::uint32_t, 2> sizes{};
    if (data.size() < sizeof sizes) throw DataError(name + ": ends within the sizes of its compressed points");
    std::memcpy(sizes.data(), data.data(), sizeof sizes);
    data.remove_prefix(sizeof sizes);
    if (sizes[0] > data.size()) {
      throw DataError(
          fmt::format("{}: states {} bytes of compressed points, and {} follow", name, sizes[0], data.size()));
    }
    if (sizes[1] != size)
      throw DataError(
          fmt::format("{}: its points unpack to {} bytes; {} points have {}", name, sizes[1], head.points, size));
    auto bytes = unpack_lzf(data.substr(0, sizes[0]), sizes[1]);
    if (!bytes) throw DataError(name + ": its compressed points are damaged");
    unpacked = std::move(*bytes);
    data = unpacked;
  }
  if (data.size() < size) {
    throw DataError(fmt::format("{}: states {} points of {} bytes, and {} bytes follow the head", name, head.points,
                                head.point_bytes(), data.size()));
  }
  // One point after the other; compressed, all numbers of a field after those of the one before.
  std::vector<std::size_t> first;
  std::vector<std::size_t> stride;
  std::size_t offset = 0;
  for (const Field& field : head.fields) {
    first.push_back(is_packed ? offset * head.points : offset);
    stride.push_back(is_packed ? field.bytes() : head.point_bytes());
    offset += field.bytes();
  }
  for (std::size_t k = 0; k < head.points; ++k) {
    point([&](int i) {
      const auto index = static_cast<std::size_t>(i);
      return number_at(data.data() + first[index] + k * stride[index], head.fields[index].type,
                       head.fields[index].size);
    });
  }
}

}  // namespace

PointFile read_pcd(std::string_view content, const std::string& name, Time stamp) {
  const Head head = HeadReader(content, name).read();
  const Taken taken = find_fields(head, name);
  PointFile file;
  PointCollector collector(file, taken.intensity >= 0, taken.time >= 0);
  const bool is_whole = taken.time >= 0 && head.fields[static_cast<std::size_t>(taken.time)].type != 'F';
  const auto point = [&](const auto& number) {
    Eigen::Vector3f p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = static_cast<float>(number(taken.xyz.at(static_cast<std::size_t>(axis))));
    collector.add(p, taken.intensity >= 0 ? number(taken.intensity) : 0.0,
                  taken.time >= 0 ? seconds_after(stamp, number(taken.time), is_whole) : 0.0);
  };
  head.data == "ascii" ? each_of_text(content, head, name, point) : each_of_bytes(content, head, name, point);
  if (head.has_viewpoint)
    file.notes.push_back(name + ": its VIEWPOINT is not the origin; the points are taken as they are");
  return file;
}

}  // namespace waymark::imports
