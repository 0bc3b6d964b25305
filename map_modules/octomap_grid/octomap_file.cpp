// SPDX-License-Identifier: Apache-2.0
#include "octomap_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <utility>

#include "column_window.hpp"
#include "waymark/error.hpp"

namespace waymark::octo {

namespace {

/// Of octomap::OcTree, and so of its files.
constexpr int kDepth = 16;
constexpr std::int32_t kMiddle = 1 << (kDepth - 1);

constexpr std::size_t kMostNodes = std::size_t{1} << 28;
constexpr std::size_t kMostTiles = std::size_t{1} << 20;

/// The text before the nodes.
struct Header {
  bool is_binary = false;  // .bt
  std::string id;
  std::size_t size = 0;
  double resolution = 0.0;
};

class Reader {
 public:
  Reader(std::filesystem::path file, const OctomapGridSettings& settings)
      : file_(std::move(file)), odds_(settings.odds), resolution_(settings.resolution), in_(file_, std::ios::binary) {}

  VoxelMap read() {
    if (!in_) fail("not found, or not readable");
    header_ = read_header();
    check_header();
    if (header_.size > 0) read_node(0, {-kMiddle, -kMiddle, -kMiddle});
    put_tile();
    if (in_.peek() != std::ifstream::traits_type::eof()) fail("there is more behind the last node");
    if (nodes_ != header_.size) fail(fmt::format("the header says {} nodes, but {} are there", header_.size, nodes_));
    return std::move(map_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw DataError(file_.string() + ": " + what); }

  Header read_header() {
    Header header;
    std::string line;
    std::getline(in_, line);
    header.is_binary = line.starts_with("# Octomap OcTree binary file");
    if (!header.is_binary && !line.starts_with("# Octomap OcTree file")) {
      fail("no octree: it must begin with \"# Octomap OcTree file\" or \"# Octomap OcTree binary file\"");
    }
    for (int lines = 0; lines < 100 && std::getline(in_, line); ++lines) {
      if (line.starts_with("data")) return header;
      if (line.empty() || line.front() == '#') continue;
      const std::size_t space = line.find(' ');
      const std::string key = line.substr(0, space);
      const std::string value = space == std::string::npos ? "" : line.substr(space + 1);
      if (key == "id") header.id = value;
      if (key == "size") header.size = static_cast<std::size_t>(number(key, value));
      if (key == "res") header.resolution = number(key, value);
    }
    fail("the header has no line \"data\"");
  }

  double number(const std::string& key, const std::string& text) const {
    std::size_t used = 0;
    double value = -1.0;
    try {
      value = std::stod(text, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || !(value >= 0.0) || value > 1e15) {
      fail(fmt::format("the header's {} is \"{}\"; a number from 0 on was expected", key, text));
    }
    return value;
  }

  /// Before memory is taken: does this fit the module, and is the file as long as it says?
  void check_header() {
    if (header_.id != "OcTree") fail(fmt::format("the header's id is \"{}\"; OcTree was expected", header_.id));
    if (std::abs(header_.resolution - resolution_) > 1e-9) {
      fail(fmt::format("its voxels have {} m, but resolution_m is {}", header_.resolution, resolution_));
    }
    if (header_.size > kMostNodes) fail(fmt::format("{} nodes; a map has at most {}", header_.size, kMostNodes));
    const auto begin = in_.tellg();
    in_.seekg(0, std::ios::end);
    const auto bytes = static_cast<std::size_t>(in_.tellg() - begin);
    in_.seekg(begin);
    if (!header_.is_binary && bytes != 5 * header_.size) {
      fail(fmt::format("{} nodes are {} bytes, but {} are there", header_.size, 5 * header_.size, bytes));
    }
    // Two bytes for eight children: so many nodes at most, and, since every inner node has a child, at least.
    if (header_.is_binary && header_.size > 0 && (header_.size > 4 * bytes + 1 || bytes > 2 * header_.size)) {
      fail(fmt::format("{} nodes do not fit into the {} bytes that are there", header_.size, bytes));
    }
  }

  template <class T>
  T next() {
    T value{};
    in_.read(reinterpret_cast<char*>(&value), sizeof value);
    if (!in_) fail(fmt::format("ends after {} of {} nodes", nodes_, header_.size));
    return value;
  }

  /// A node of a .ot file, or an inner one of a .bt file.
  void read_node(int depth, Voxel corner) {
    ++nodes_;
    if (nodes_ > header_.size) fail(fmt::format("the header says {} nodes, but there are more", header_.size));
    if (header_.is_binary) {
      read_binary(depth, corner);
    } else {
      read_full(depth, corner);
    }
  }

  void read_full(int depth, Voxel corner) {
    const auto value = next<float>();
    const auto children = next<std::uint8_t>();
    if (!std::isfinite(value)) fail(fmt::format("node {} has log-odds of {}", nodes_, value));
    if (children == 0) return add_leaf(depth, corner, std::clamp(value, odds_.low, odds_.high));
    if (depth == kDepth) fail(fmt::format("nodes below depth {}", kDepth));
    for (unsigned i = 0; i < 8; ++i) {
      if ((children >> i & 1u) != 0) read_node(depth + 1, child_of(corner, depth, i));
    }
  }

  void read_binary(int depth, Voxel corner) {
    if (depth == kDepth) fail(fmt::format("nodes below depth {}", kDepth));
    const unsigned low = next<std::uint8_t>();
    const unsigned children = low | static_cast<unsigned>(next<std::uint8_t>()) << 8;
    for (unsigned i = 0; i < 8; ++i) {
      const unsigned kind = children >> (2 * i) & 3u;
      const Voxel at = child_of(corner, depth, i);
      if (kind == 3u) read_node(depth + 1, at);
      if (kind != 1u && kind != 2u) continue;
      ++nodes_;
      add_leaf(depth + 1, at, 0.5f * (kind == 1u ? odds_.low : odds_.high));
    }
  }

  static Voxel child_of(Voxel corner, int depth, unsigned i) {
    const std::int32_t half = 1 << (kDepth - depth - 1);
    return {corner.x + ((i & 1u) != 0 ? half : 0), corner.y + ((i & 2u) != 0 ? half : 0),
            corner.z + ((i & 4u) != 0 ? half : 0)};
  }

  void add_leaf(int depth, Voxel corner, float odds) {
    const int level = kDepth - depth;
    constexpr int kBits = VoxelOctree::kBits;
    const std::int32_t tiles = level > kBits ? 1 << (level - kBits) : 1;
    const auto count =
        static_cast<std::size_t>(tiles) * static_cast<std::size_t>(tiles) * static_cast<std::size_t>(tiles);
    if (level > kBits) room_for(count);
    for (std::int32_t y = 0; y < tiles; ++y) {
      for (std::int32_t x = 0; x < tiles; ++x) {
        for (std::int32_t z = 0; z < tiles; ++z) {
          VoxelOctree::Draft& tile = tile_at({tile_of(corner.x) + x, tile_of(corner.y) + y}, tile_of(corner.z) + z);
          constexpr std::int32_t kLast = VoxelOctree::kSide - 1;
          const LocalVoxel at{static_cast<std::uint8_t>(corner.x & kLast), static_cast<std::uint8_t>(corner.y & kLast),
                              static_cast<std::uint8_t>(corner.z & kLast)};
          tile.set(at, std::min(level, kBits), odds);
        }
      }
    }
  }

  /// Leaves come in the octree's order, so those of one tile come one after the other.
  VoxelOctree::Draft& tile_at(TileIndex index, std::int32_t z) {
    if (tiles_ == 0 || index != index_ || z != z_) {
      put_tile();
      room_for(1);
      ++tiles_;
      index_ = index;
      z_ = z;
    }
    return tile_;
  }
  /// The tile whose leaves were read last.
  void put_tile() {
    if (tiles_ == 0) return;
    map_.write(index_).write(z_).voxels = VoxelOctree(tile_);
    tile_.known.fill(0);
  }
  void room_for(std::size_t more) const {
    if (tiles_ + more > kMostTiles) {
      fail(fmt::format("the map fills more than {} cubes of {} voxels, the most that a map can have", kMostTiles,
                       VoxelOctree::kVoxels));
    }
  }

  std::filesystem::path file_;
  VoxelOdds odds_;
  double resolution_;
  std::ifstream in_;
  Header header_;
  VoxelMap map_;
  std::size_t nodes_ = 0;  // so far
  std::size_t tiles_ = 0;
  VoxelOctree::Draft tile_;  // the last of them
  TileIndex index_;
  std::int32_t z_ = 0;
};

/// Distances of a map of which only the odds are known, column by column.
void compute_distances(VoxelMap& map) {
  constexpr std::int32_t kSide = VoxelOctree::kSide;
  struct Placed {
    TileIndex index;
    std::vector<Voxel> occupied;  // in the column
  };
  std::vector<Placed> all;
  map.for_all([&](TileIndex index, const TileColumn& column, bool) {
    std::vector<Voxel> occupied;
    column.for_all([&](std::int32_t z, const VoxelTile& tile, bool) {
      tile.voxels.for_all([&](LocalVoxel v, int side, float odds) {
        if (!is_occupied(odds)) return;
        for (int i = 0; i < side * side * side; ++i)
          occupied.push_back({v.x + i % side, v.y + i / side % side, z * kSide + v.z + i / (side * side)});
      });
    });
    if (!occupied.empty()) all.push_back({index, std::move(occupied)});
  });
  ColumnWindow window;
  DistanceUpdate update;
  std::vector<LayerCell> none;
  std::vector<LayerCell> cells;
  for (const Placed& placed : all) {
    const Eigen::Vector2d corner(placed.index.x * kSide, placed.index.y * kSide);  // in voxels
    window.open(map, corner.array() - kSide, corner.array() + 1.5 * kSide, 1.0);
    const Cell from{(placed.index.x - window.rect().low.x) * kSide, (placed.index.y - window.rect().low.y) * kSide};
    const std::int32_t row = placed.index.y - window.rect().low.y;
    const std::int32_t slot_in_rect = row * window.rect().width() + (placed.index.x - window.rect().low.x);
    const auto slot = static_cast<std::size_t>(slot_in_rect);
    cells.clear();
    for (const Voxel v : placed.occupied) {
      window.writable(slot).write(tile_of(v.z)).write_slab(v.z).set_occupied(v.x, v.y, true);
      cells.push_back({v.z, {from.x + v.x, from.y + v.y}});
    }
    update.apply(window, none, cells);
  }
}

}  // namespace

VoxelMap load_octomap(const std::filesystem::path& file, const OctomapGridSettings& settings) {
  VoxelMap map = Reader(file, settings).read();
  compute_distances(map);
  return map;
}

}  // namespace waymark::octo
