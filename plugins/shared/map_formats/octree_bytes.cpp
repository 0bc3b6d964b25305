// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/octree_bytes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::map_formats {

namespace {

constexpr std::string_view kBinary = "# Octomap OcTree binary file";
constexpr std::string_view kFull = "# Octomap OcTree file";
constexpr double kCoarsest = 1000.0;
constexpr std::int32_t kMiddle = 1 << (OctreeBytes::kDepth - 1);  // voxels from an end of the octree to the origin

using Corner = std::array<std::int32_t, 3>;

/// The lines of the header, one after the other.
class HeaderLines {
 public:
  explicit HeaderLines(std::string_view content) : content_(content) {}

  /// The next line, without its end; nothing at the end of the file.
  std::optional<std::string_view> next() {
    if (at_ >= content_.size()) return std::nullopt;
    const std::size_t end = content_.find('\n', at_);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view text = content_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }
  std::size_t at() const { return at_; }

 private:
  std::string_view content_;
  std::size_t at_ = 0;
};

template <class T>
T octree_number(std::string_view text, std::string_view key, const OctreeBytes& bytes) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size())
    bytes.fail(fmt::format("header: {} is \"{}\"; a number was expected", key, text));
  return value;
}

/// Goes through the nodes, which follow one another as in a walk that goes down first.
class NodeWalk {
 public:
  NodeWalk(const OctreeBytes& bytes, const std::function<void(const OctreeLeaf&)>& visit)
      : bytes_(bytes), visit_(visit), at_(bytes.data_begin()) {}

  void walk() {
    constexpr Corner kLowest{-kMiddle, -kMiddle, -kMiddle};
    if (bytes_.nodes() > 0) {
      if (bytes_.is_binary()) {
        nodes_ = 1;
        inner_of_binary(0, kLowest);
      } else {
        node_of_full(0, kLowest);
      }
    }
    if (nodes_ != bytes_.nodes())
      bytes_.fail(fmt::format("header: size is {} nodes, but {} are there", bytes_.nodes(), nodes_));
    if (left() > 0) bytes_.fail(fmt::format("{} bytes follow the last node; none were expected", left()));
  }

 private:
  std::size_t left() const { return bytes_.content().size() - at_; }

  template <class T>
  T value() {
    if (left() < sizeof(T)) {
      bytes_.fail(fmt::format("truncated: {} of {} nodes are there, the file ends at byte {}", nodes_, bytes_.nodes(),
                              bytes_.content().size()));
    }
    T value;
    std::memcpy(&value, bytes_.content().data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  void require_room(int depth) const {
    if (depth < OctreeBytes::kDepth) return;
    bytes_.fail(fmt::format("byte {}: a node below the {} levels of an octree", at_, OctreeBytes::kDepth));
  }

  static Corner child_of(const Corner& corner, int depth, unsigned child) {
    const std::int32_t half = 1 << (OctreeBytes::kDepth - depth - 1);
    Corner of_child = corner;
    for (unsigned axis = 0; axis < 3; ++axis) of_child[axis] += (child >> axis & 1u) != 0 ? half : 0;
    return of_child;
  }

  /// `.bt`: two bytes for an inner node, two bits for each child: 0 unknown, 1 free, 2 occupied, 3 with children.
  void inner_of_binary(int depth, const Corner& corner) {
    require_room(depth);
    const auto children = value<std::uint16_t>();
    if (children == 0 && depth > 0) bytes_.fail(fmt::format("byte {}: an inner node without children", at_ - 2));
    for (unsigned child = 0; child < 8; ++child) {
      const unsigned kind = children >> (2 * child) & 3u;
      if (kind == 0) continue;
      ++nodes_;
      const Corner low = child_of(corner, depth, child);
      if (kind == 3) {
        inner_of_binary(depth + 1, low);
      } else {
        visit_({low, OctreeBytes::kDepth - depth - 1, kind == 2, 0.0f});
      }
    }
  }

  /// `.ot`: log-odds as a float, then one bit for each child that is there.
  void node_of_full(int depth, const Corner& corner) {
    const auto odds = value<float>();
    const unsigned children = value<std::uint8_t>();
    if (!std::isfinite(odds)) bytes_.fail(fmt::format("byte {}: log-odds are {}", at_ - 5, odds));
    ++nodes_;
    if (children == 0) {
      visit_({corner, OctreeBytes::kDepth - depth, odds > 0.0f, odds});
      return;
    }
    require_room(depth);
    for (unsigned child = 0; child < 8; ++child) {
      if ((children >> child & 1u) != 0) node_of_full(depth + 1, child_of(corner, depth, child));
    }
  }

  const OctreeBytes& bytes_;
  const std::function<void(const OctreeLeaf&)>& visit_;
  std::size_t at_;
  std::uint64_t nodes_ = 0;
};

}  // namespace

/// Lines `key value` until `data`; comments begin with #.
OctreeBytes::OctreeBytes(std::string content, std::filesystem::path file)
    : content_(std::move(content)), file_(std::move(file)) {
  HeaderLines lines(content_);
  const std::string_view first = lines.next().value_or("");
  is_binary_ = first.starts_with(kBinary);
  if (!is_binary_ && !first.starts_with(kFull))
    fail(fmt::format("not an octree of OctoMap: the first line must be \"{}\" or \"{}\"", kBinary, kFull));
  std::optional<std::string_view> id;
  std::optional<std::uint64_t> nodes;
  std::optional<double> resolution;
  for (auto line = lines.next(); line != "data"; line = lines.next()) {
    if (!line) fail("header: the line \"data\" is missing");
    if (line->empty() || line->starts_with('#')) continue;
    const std::size_t space = std::min(line->find(' '), line->size());
    const std::string_view key = line->substr(0, space);
    const std::string_view value = line->substr(std::min(space + 1, line->size()));
    if (key == "id") {
      id = value;
    } else if (key == "size") {
      nodes = octree_number<std::uint64_t>(value, key, *this);
    } else if (key == "res") {
      resolution = octree_number<double>(value, key, *this);
    } else {
      fail(fmt::format("header: \"{}\" is not expected; id, size, res, data are", line->substr(0, 40)));
    }
  }
  if (!id || !nodes || !resolution) fail("header: id, size and res are expected before data");
  if (*id != "OcTree") fail(fmt::format("header: id is {}; only trees of the id OcTree are read", *id));
  if (!(*resolution > 0.0) || *resolution > kCoarsest) {
    fail(fmt::format("header: res is {} m; more than 0 and at most {} was expected", *resolution, kCoarsest));
  }
  data_begin_ = lines.at();
  nodes_ = *nodes;
  resolution_m_ = *resolution;
}

OctreeBytes OctreeBytes::read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in || !std::filesystem::is_regular_file(file))
    throw DataError(fmt::format("{}: not found, or not readable", file.string()));
  std::string content(static_cast<std::size_t>(in.tellg()), '\0');
  in.seekg(0);
  in.read(content.data(), static_cast<std::streamsize>(content.size()));
  if (!in) throw DataError(fmt::format("{}: reading failed", file.string()));
  return {std::move(content), file};
}

void OctreeBytes::for_leaves(const std::function<void(const OctreeLeaf&)>& visit) const {
  static_assert(std::endian::native == std::endian::little, "liboctomap writes in the machine's own order");
  NodeWalk(*this, visit).walk();
}

void OctreeBytes::fail(const std::string& what) const { throw DataError(fmt::format("{}: {}", file_.string(), what)); }

std::string octree_header(bool is_binary, std::uint64_t nodes, double resolution_m) {
  return fmt::format(
      "{}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\nid OcTree\nsize {}\nres {}\n"
      "data\n",
      is_binary ? kBinary : kFull, nodes, resolution_m);
}

}  // namespace waymark::map_formats
