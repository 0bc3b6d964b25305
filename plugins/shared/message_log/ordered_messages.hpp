// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <string>
#include <tuple>
#include <vector>

#include "plugins/shared/message_log/message_log.hpp"

namespace waymark::message_log {

/// A part of a recording that is loaded as a whole, such as a chunk.
struct Part {
  std::size_t file = 0;
  std::size_t number = 0;    ///< in its file
  Time first = Time::max();  ///< of the recording of its messages
};

/// The messages of a part, with the memory that they keep.
struct LoadedPart {
  std::vector<Message> messages;
  std::size_t bytes = 0;
};

/// Messages in order of the time of recording. Equal times stay in the order of the files and of their bytes. Only
/// parts that overlap in time are in memory together.
class OrderedMessages {
 public:
  using Load = std::function<LoadedPart(const Part& part, BadRecordList& bad)>;

  /// `most_bytes`: what the parts that overlap in time may take in memory, 1 GiB at most.
  OrderedMessages(std::vector<Part> parts, Load load, std::uint64_t most_bytes = kMostBytes);

  /// The next message, or nothing at the end. Throws DataError if the parts that overlap are larger than that, and what
  /// loading throws.
  std::optional<Message> next(BadRecordList& bad);

  /// Share of the parts that was read, 0..1.
  double progress() const;

  static constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;

 private:
  struct Later {
    bool operator()(const Message& a, const Message& b) const {
      return std::tie(a.recorded, a.file, a.record, a.offset) > std::tie(b.recorded, b.file, b.record, b.offset);
    }
  };
  struct InMemory {
    std::size_t messages_left = 0;
    std::size_t bytes = 0;
  };

  void load_next(BadRecordList& bad);

  std::vector<Part> parts_;
  Load load_;
  std::uint64_t most_bytes_;
  std::size_t next_part_ = 0;
  std::priority_queue<Message, std::vector<Message>, Later> pending_;
  std::map<std::pair<std::size_t, std::uint64_t>, InMemory> in_memory_;  // by file and record
  std::size_t bytes_in_memory_ = 0;
};

}  // namespace waymark::message_log
