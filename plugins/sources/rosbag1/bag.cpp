// SPDX-License-Identifier: Apache-2.0
#include "bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "decompress.hpp"
#include "waymark/base/error.hpp"

namespace waymark::rosbag1 {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kLongestHeader = 1 << 20;
constexpr std::uint32_t kLargestChunk = 1 << 30;
constexpr std::uint32_t kIndexVersion = 1;
constexpr std::size_t kIndexEntry = 12;  // time, place in the chunk

std::string printable(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '.');
  return text;
}

}  // namespace

Bag::Bag(std::filesystem::path file) : file_(std::move(file)), in_(file_, std::ios::binary) {
  std::error_code error;
  if (std::filesystem::is_directory(file_, error)) throw DataError(file_.string() + ": is a folder, a bag is expected");
  if (!in_) throw DataError(fmt::format("{}: cannot be read: {}", file_.string(), std::strerror(errno)));
  size_ = std::filesystem::file_size(file_, error);
  if (error) throw DataError(fmt::format("{}: cannot be read: {}", file_.string(), error.message()));
  const std::vector<std::uint8_t> start = read(0, std::min<std::uint64_t>(size_, kMagic.size()));
  if (!std::equal(start.begin(), start.end(), kMagic.begin(), kMagic.end())) {
    throw DataError(fmt::format(R"({}: begins with "{}", but a bag of ROS 1 of format 2.0 begins with "#ROSBAG V2.0")",
                                place(0), printable({start.begin(), start.end()})));
  }
  walk();
  look_into_where_needed();
}

std::string Bag::place(std::uint64_t offset) const { return fmt::format("{}:byte {}", file_.string(), offset); }

std::vector<std::uint8_t> Bag::read(std::uint64_t offset, std::uint64_t count) {
  std::vector<std::uint8_t> bytes(count);
  in_.clear();
  in_.seekg(static_cast<std::streamoff>(offset));
  in_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
  if (!in_) throw DataError(place(offset) + ": cannot be read on");
  return bytes;
}

void Bag::walk() {
  std::uint64_t offset = kMagic.size();
  try {
    while (offset < size_) {
      if (!walk_record(offset)) break;
    }
  } catch (const ros::Unusable& bad) {
    broken_at_ = offset;
    broken_because_ = fmt::format("here a record is expected, but {}", bad.what());
  }
}

/// Takes one record and moves behind it. False where the file ends within it.
bool Bag::walk_record(std::uint64_t& offset) {
  const auto ends_early = [&] {
    broken_at_ = offset;
    broken_because_ = "the bag ends early, within the record that begins here";
    return false;
  };
  constexpr std::uint64_t kLength = sizeof(std::uint32_t);
  const auto length_at = [&](std::uint64_t at) { return ros::WireReader(read(at, kLength)).value<std::uint32_t>(); };
  if (size_ - offset < kLength) return ends_early();
  const std::uint32_t header_length = length_at(offset);
  if (header_length > kLongestHeader) throw ros::Unusable(fmt::format("its header would have {} bytes", header_length));
  if (size_ - offset < kLength + header_length + kLength) return ends_early();
  const std::vector<std::uint8_t> header_bytes = read(offset + kLength, header_length);
  const RecordHeader header(header_bytes);
  const std::uint64_t data = offset + kLength + header_length + kLength;
  const std::uint64_t data_length = length_at(data - kLength);
  const bool whole = data_length <= size_ - data;
  switch (header.op()) {
    case Op::chunk:
      add_chunk(header, offset, data, std::min(data_length, size_ - data));
      chunks_.back().whole = whole;
      break;
    case Op::index:
      if (whole) add_index(header, data, data_length);
      break;
    case Op::connection:
      if (whole) {
        Connection connection = read_connection(header, read(data, data_length));
        connections_.insert_or_assign(connection.number, std::move(connection));
      }
      break;
    default:
      break;
  }
  if (!whole) return ends_early();
  offset = data + data_length;
  return true;
}

void Bag::add_chunk(const RecordHeader& header, std::uint64_t offset, std::uint64_t data, std::uint64_t stored) {
  Chunk chunk{.offset = offset,
              .data = data,
              .stored = stored,
              .size = header.number<std::uint32_t>("size"),
              .compression = header.text("compression"),
              .count = {}};
  if (!knows_compression(chunk.compression)) {
    throw DataError(fmt::format(R"({}: the compression "{}" is not known; "none", "bz2" or "lz4" is expected)",
                                place(offset), printable(chunk.compression)));
  }
  if (std::max<std::uint64_t>(chunk.size, stored) > kLargestChunk)
    throw ros::Unusable(fmt::format("a chunk would have {} bytes", std::max<std::uint64_t>(chunk.size, stored)));
  if (chunk.size > most_unpacked(stored))
    throw ros::Unusable(fmt::format("a chunk of {} bytes would unpack to {}", stored, chunk.size));
  chunks_.push_back(std::move(chunk));
}

void Bag::add_index(const RecordHeader& header, std::uint64_t data, std::uint64_t size) {
  const auto connection = header.number<std::uint32_t>("conn");
  const std::uint64_t count = header.number<std::uint32_t>("count");
  // If an index is uncertain, the chunk itself is read.
  if (chunks_.empty() || header.number<std::uint32_t>("ver") != kIndexVersion || count * kIndexEntry != size) return;
  const std::vector<std::uint8_t> bytes = read(data, size);
  Chunk& chunk = chunks_.back();
  ros::WireReader wire(bytes);
  while (wire.left() > 0) {
    chunk.first = std::min(chunk.first, wire.time());
    wire.take(sizeof(std::uint32_t));
  }
  chunk.count[connection] += count;
}

void Bag::look_into(Chunk& chunk) {
  const ChunkContent content = load(chunk);
  chunk.count.clear();
  chunk.first = Time::max();
  read_chunk(
      content.bytes,
      [&](const StoredMessage& message) {
        chunk.first = std::min(chunk.first, message.recorded);
        ++chunk.count[message.connection];
      },
      [&](Connection connection) { connections_.try_emplace(connection.number, std::move(connection)); });
}

void Bag::look_into_where_needed() {
  for (Chunk& chunk : chunks_) {
    // Of the last chunk of a bag that ends early, part of the index may be missing.
    const bool last = &chunk == &chunks_.back();
    const bool unknown =
        std::ranges::any_of(chunk.count, [this](const auto& entry) { return !connections_.contains(entry.first); });
    if (chunk.count.empty() || unknown || (last && !broken_because_.empty())) look_into(chunk);
  }
}

std::uint64_t Bag::messages(std::uint32_t connection) const {
  std::uint64_t sum = 0;
  for (const Chunk& chunk : chunks_) {
    const auto found = chunk.count.find(connection);
    if (found != chunk.count.end()) sum += found->second;
  }
  return sum;
}

ChunkContent Bag::load(const Chunk& chunk) {
  const std::vector<std::uint8_t> stored = read(chunk.data, chunk.stored);
  Decompressed result = decompress(chunk.compression, stored, chunk.size);
  return {std::move(result.bytes), std::move(result.problem)};
}

}  // namespace waymark::rosbag1
