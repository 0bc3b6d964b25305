// SPDX-License-Identifier: Apache-2.0
#include "octree_bytes.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "waymark/error.hpp"

namespace waymark::maps {

namespace {

constexpr std::string_view kBinary = "# Octomap OcTree binary file";
constexpr std::string_view kFull = "# Octomap OcTree file";
constexpr unsigned kDepth = 16;  // of the smallest voxels of an octomap::OcTree
constexpr double kCoarsest = 1000.0;

/// Reads from the front of the bytes and knows how far it is.
class Cursor {
 public:
  Cursor(std::string_view content, const std::filesystem::path& file) : content_(content), file_(file) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(fmt::format("{}: {}", file_.string(), what));
  }
  /// The next line, without its end; nothing at the end of the file.
  std::optional<std::string_view> line() {
    if (at_ >= content_.size()) return std::nullopt;
    const std::size_t end = content_.find('\n', at_);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view text = content_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }
  template <class T>
  T value(std::uint64_t nodes, std::uint64_t expected) {
    if (content_.size() - at_ < sizeof(T)) {
      fail(fmt::format("truncated: {} of {} nodes are there, the file ends at byte {}", nodes, expected,
                       content_.size()));
    }
    T value;
    std::memcpy(&value, content_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::size_t at() const { return at_; }
  std::size_t left() const { return content_.size() - at_; }

 private:
  std::string_view content_;
  const std::filesystem::path& file_;
  std::size_t at_ = 0;
};

template <class T>
T number(std::string_view text, std::string_view key, const Cursor& cursor) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size())
    cursor.fail(fmt::format("header: {} is \"{}\"; a number was expected", key, text));
  return value;
}

/// Lines `key value` until `data`; comments begin with #.
OctreeBytes read_header(Cursor& cursor) {
  OctreeBytes header;
  const std::string_view first = cursor.line().value_or("");
  header.is_binary = first.starts_with(kBinary);
  if (!header.is_binary && !first.starts_with(kFull)) {
    cursor.fail(fmt::format("no octree of OctoMap: the first line must be \"{}\" or \"{}\"", kBinary, kFull));
  }
  std::optional<std::string_view> id;
  std::optional<std::uint64_t> nodes;
  std::optional<double> resolution;
  for (auto line = cursor.line(); line != "data"; line = cursor.line()) {
    if (!line) cursor.fail("header: the line \"data\" is missing");
    if (line->empty() || line->starts_with('#')) continue;
    const std::size_t space = std::min(line->find(' '), line->size());
    const std::string_view key = line->substr(0, space);
    const std::string_view value = line->substr(std::min(space + 1, line->size()));
    if (key == "id") {
      id = value;
    } else if (key == "size") {
      nodes = number<std::uint64_t>(value, key, cursor);
    } else if (key == "res") {
      resolution = number<double>(value, key, cursor);
    } else {
      cursor.fail(fmt::format("header: \"{}\" is not expected; id, size, res, data are", line->substr(0, 40)));
    }
  }
  if (!id || !nodes || !resolution) cursor.fail("header: id, size and res are expected before data");
  if (*id != "OcTree") cursor.fail(fmt::format("header: id is {}; only trees of the id OcTree are read", *id));
  if (!(*resolution > 0.0) || *resolution > kCoarsest) {
    cursor.fail(fmt::format("header: res is {} m; more than 0 and at most {} was expected", *resolution, kCoarsest));
  }
  header.data_begin = cursor.at();
  header.nodes = *nodes;
  header.resolution_m = *resolution;
  return header;
}

/// Depths of the inner nodes whose bytes are still to come, the next one last.
using Pending = std::vector<unsigned>;

void require_room(unsigned depth, const Cursor& cursor) {
  if (depth < kDepth) return;
  cursor.fail(fmt::format("byte {}: a node below the {} levels of an octree", cursor.at(), kDepth));
}

/// `.bt`: two bytes for an inner node, two bits for each child: 0 unknown, 1 free, 2 occupied, 3 with children.
std::uint64_t walk_binary(Cursor& cursor, std::uint64_t expected) {
  std::uint64_t nodes = 1;
  Pending pending{0};
  while (!pending.empty()) {
    const unsigned depth = pending.back();
    pending.pop_back();
    require_room(depth, cursor);
    const auto children = cursor.value<std::uint16_t>(nodes, expected);
    if (children == 0 && depth > 0)
      cursor.fail(fmt::format("byte {}: an inner node without children", cursor.at() - 2));
    for (unsigned child = 0; child < 8; ++child) {
      const unsigned bits = (children >> (2 * child)) & 3u;
      if (bits != 0) ++nodes;
      if (bits == 3) pending.push_back(depth + 1);
    }
  }
  return nodes;
}

/// `.ot`: log-odds as a float, then one bit for each child that is there.
std::uint64_t walk_full(Cursor& cursor, std::uint64_t expected) {
  std::uint64_t nodes = 0;
  Pending pending{0};
  while (!pending.empty()) {
    const unsigned depth = pending.back();
    pending.pop_back();
    const auto odds = cursor.value<float>(nodes, expected);
    const auto children = cursor.value<std::uint8_t>(nodes, expected);
    if (!std::isfinite(odds)) cursor.fail(fmt::format("byte {}: log-odds are {}", cursor.at() - 5, odds));
    ++nodes;
    if (children != 0) require_room(depth, cursor);
    pending.insert(pending.end(), static_cast<std::size_t>(std::popcount(children)), depth + 1);
  }
  return nodes;
}

}  // namespace

OctreeBytes inspect_octree(std::string_view content, const std::filesystem::path& file) {
  static_assert(std::endian::native == std::endian::little, "liboctomap writes in the machine's own order");
  Cursor cursor(content, file);
  const OctreeBytes header = read_header(cursor);
  std::uint64_t nodes = 0;
  if (header.nodes > 0) nodes = header.is_binary ? walk_binary(cursor, header.nodes) : walk_full(cursor, header.nodes);
  if (nodes != header.nodes)
    cursor.fail(fmt::format("header: size is {} nodes, but {} are there", header.nodes, nodes));
  if (cursor.left() > 0) cursor.fail(fmt::format("{} bytes follow the last node; none were expected", cursor.left()));
  return header;
}

}  // namespace waymark::maps
