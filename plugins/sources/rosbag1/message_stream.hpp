// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bag.hpp"
#include "waymark/io/bad_record_list.hpp"

namespace waymark::rosbag1 {

/// A message in memory.
struct RawMessage {
  Time recorded;
  std::size_t bag = 0;
  std::uint32_t connection = 0;
  Bytes data;
  std::uint64_t chunk_offset = 0;             ///< of the chunk in the file
  std::size_t offset = 0;                     ///< of the message in the chunk
  std::shared_ptr<const ChunkContent> chunk;  ///< holds the data
};

/// The messages of some connections of several bags, in order of the time of recording. Equal times stay in the order
/// of the bags and of their bytes. Only chunks that overlap in time are in memory together.
class MessageStream {
 public:
  /// `wanted`: pairs of bag and connection. The bags must outlive this.
  MessageStream(std::vector<Bag>& bags, std::set<std::pair<std::size_t, std::uint32_t>> wanted);

  /// The next message, or nothing at the end. Damaged chunks, and at the end bags that are not whole, go to `bad`.
  /// Throws DataError if a file cannot be read or `bad` is full.
  std::optional<RawMessage> next(BadRecordList& bad);

  /// "file:byte n, …", for errors.
  std::string place(const RawMessage& message) const;

  /// Share of the chunks that was read, 0..1.
  double progress() const;

 private:
  struct Entry {
    Time recorded;
    std::size_t bag;
    std::uint64_t chunk_offset;
    std::size_t offset;  // in the chunk
    std::uint32_t connection;
    Bytes data;
    std::shared_ptr<const ChunkContent> content;

    bool operator>(const Entry& other) const {
      return std::tie(recorded, bag, chunk_offset, offset) >
             std::tie(other.recorded, other.bag, other.chunk_offset, other.offset);
    }
  };

  void load_chunk(BadRecordList& bad);

  std::vector<Bag>* bags_;
  std::set<std::pair<std::size_t, std::uint32_t>> wanted_;
  std::vector<std::pair<std::size_t, const Chunk*>> chunks_;  // with their bags, by the time of their first message
  std::size_t next_chunk_ = 0;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> pending_;
  std::size_t next_ending_ = 0;  // of the bags, whose end has not been looked at
};

}  // namespace waymark::rosbag1
