// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace waymark::map_formats {

/// A leaf of one of OctoMap's octrees: a cube of 2^level voxels in each direction.
struct OctreeLeaf {
  std::array<std::int32_t, 3> low{};  ///< the lowest voxel, counted from the map's origin
  int level = 0;
  bool is_occupied = false;
  float odds = 0.0f;  ///< natural log-odds; 0 in a `.bt`, which has none
};

/// The bytes of a `.bt` or `.ot`. They are checked here, not by liboctomap: it neither notices the end of a
/// truncated file nor bounds the depth of what it reads, and writes debug output to standard error.
class OctreeBytes {
 public:
  /// Levels of an octomap::OcTree above its smallest voxels.
  static constexpr int kDepth = 16;

  /// Reads the header; `file` is for messages. Throws DataError with the file, what is wrong, and what was expected.
  OctreeBytes(std::string content, std::filesystem::path file);
  /// Throws DataError if there is no such file, too.
  static OctreeBytes read(const std::filesystem::path& file);

  bool is_binary() const { return is_binary_; }          ///< .bt: a leaf is occupied or free; else .ot: log-odds
  double resolution_m() const { return resolution_m_; }  ///< side of the smallest voxel
  std::uint64_t nodes() const { return nodes_; }         ///< inner ones and leaves, by the header
  const std::string& content() const { return content_; }
  std::size_t data_begin() const { return data_begin_; }  ///< byte of the content at which the nodes begin

  /// Calls visit(leaf) for all leaves in the octree's order. Throws DataError with the file, what is wrong, at which
  /// byte, and what was expected; leaves before that were visited.
  void for_leaves(const std::function<void(const OctreeLeaf&)>& visit) const;
  /// Throws DataError as `for_leaves` does.
  void check() const {
    for_leaves([](const OctreeLeaf&) {});
  }
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string content_;
  std::filesystem::path file_;
  bool is_binary_ = false;
  double resolution_m_ = 0.0;
  std::size_t data_begin_ = 0;
  std::uint64_t nodes_ = 0;
};

/// The text at the beginning of such a file. Not written by liboctomap, which prints to standard error and rounds the
/// resolution to six digits.
std::string octree_header(bool is_binary, std::uint64_t nodes, double resolution_m);

}  // namespace waymark::map_formats
