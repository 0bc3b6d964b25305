// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "bag_records.hpp"
#include "waymark/base/time.hpp"

namespace waymark::rosbag1 {

/// Where a chunk lies and what its index lists.
struct Chunk {
  std::uint64_t offset = 0;  ///< of its record in the file
  std::uint64_t data = 0;    ///< of its compressed bytes
  std::uint64_t stored = 0;  ///< how many of them there are
  std::uint32_t size = 0;    ///< uncompressed
  std::string compression;
  bool whole = true;                             ///< false: the file ends within it
  Time first = Time::max();                      ///< when its earliest message was recorded
  std::map<std::uint32_t, std::uint64_t> count;  ///< messages of each connection
};

/// A chunk in memory.
struct ChunkContent {
  std::vector<std::uint8_t> bytes;
  std::string problem;  ///< why bytes are missing at the end; empty: none are
};

/// A bag of format 2.0. Its records are walked through once, from one to the next without reading the chunks, so that a
/// bag that was never closed and has no index is as good as any other; a chunk without an index is looked into.
class Bag {
 public:
  /// Throws DataError ("file:byte n: …") if the file cannot be read or is not a bag of ROS 1.
  explicit Bag(std::filesystem::path file);

  const std::filesystem::path& file() const { return file_; }
  std::uint64_t size() const { return size_; }
  /// By their numbers, which other records refer to.
  const std::map<std::uint32_t, Connection>& connections() const { return connections_; }
  const std::vector<Chunk>& chunks() const { return chunks_; }  ///< in the order of the file
  /// Where and why the walk stopped before the end of the file; an empty reason: it did not.
  std::uint64_t broken_at() const { return broken_at_; }
  const std::string& broken_because() const { return broken_because_; }

  /// Messages of a connection, as far as they can be read.
  std::uint64_t messages(std::uint32_t connection) const;
  /// Reads and decompresses a chunk. Throws DataError if the file cannot be read.
  ChunkContent load(const Chunk& chunk);
  /// "file:byte n".
  std::string place(std::uint64_t offset) const;

 private:
  void walk();
  bool walk_record(std::uint64_t& offset);
  void add_chunk(const RecordHeader& header, std::uint64_t offset, std::uint64_t data, std::uint64_t stored);
  void add_index(const RecordHeader& header, std::uint64_t data, std::uint64_t size);
  void look_into(Chunk& chunk);
  void look_into_where_needed();
  std::vector<std::uint8_t> read(std::uint64_t offset, std::uint64_t count);

  std::filesystem::path file_;
  std::ifstream in_;
  std::uint64_t size_ = 0;
  std::map<std::uint32_t, Connection> connections_;
  std::vector<Chunk> chunks_;
  std::uint64_t broken_at_ = 0;
  std::string broken_because_;
};

}  // namespace waymark::rosbag1
