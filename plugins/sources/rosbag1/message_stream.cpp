// SPDX-License-Identifier: Apache-2.0
#include "message_stream.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace waymark::rosbag1 {

MessageStream::MessageStream(std::vector<Bag>& bags, std::set<std::pair<std::size_t, std::uint32_t>> wanted)
    : bags_(&bags), wanted_(std::move(wanted)) {
  for (std::size_t bag = 0; bag < bags.size(); ++bag) {
    for (const Chunk& chunk : bags[bag].chunks()) {
      // One without any message is damaged from its start on: that is to be reported.
      const bool of_use = chunk.count.empty() || std::ranges::any_of(chunk.count, [&](const auto& entry) {
                            return wanted_.contains({bag, entry.first});
                          });
      if (of_use) chunks_.emplace_back(bag, &chunk);
    }
  }
  std::ranges::stable_sort(chunks_, {}, [](const auto& chunk) { return chunk.second->first; });
}

void MessageStream::load_chunk(BadRecordList& bad) {
  const auto [bag_index, chunk] = chunks_[next_chunk_++];
  Bag& bag = (*bags_)[bag_index];
  const auto content = std::make_shared<const ChunkContent>(bag.load(*chunk));
  const std::string problem = read_chunk(
      content->bytes,
      [&, bag_number = bag_index, where = chunk](const StoredMessage& message) {
        if (!wanted_.contains({bag_number, message.connection})) return;
        pending_.push(
            {message.recorded, bag_number, where->offset, message.offset, message.connection, message.data, content});
      },
      nullptr);
  if (!chunk->whole) return;  // reported at the end
  if (!content->problem.empty()) {
    bad.add(bag.place(chunk->offset), fmt::format("a chunk is damaged: {}", content->problem));
  } else if (!problem.empty()) {
    bad.add(bag.place(chunk->offset), fmt::format("a chunk is damaged: {}", problem));
  }
}

std::optional<RawMessage> MessageStream::next(BadRecordList& bad) {
  while (next_chunk_ < chunks_.size() &&
         (pending_.empty() || chunks_[next_chunk_].second->first <= pending_.top().recorded)) {
    load_chunk(bad);
  }
  if (!pending_.empty()) {
    const Entry& entry = pending_.top();
    RawMessage message{entry.recorded,     entry.bag,    entry.connection, entry.data,
                       entry.chunk_offset, entry.offset, entry.content};
    pending_.pop();
    return message;
  }
  while (next_ending_ < bags_->size()) {
    const Bag& bag = (*bags_)[next_ending_++];
    if (!bag.broken_because().empty()) {
      bad.add(bag.place(bag.broken_at()), bag.broken_because() + "; all that comes before it was read");
    }
  }
  return std::nullopt;
}

std::string MessageStream::place(const RawMessage& message) const {
  return fmt::format("{}, message at byte {} of the chunk", (*bags_)[message.bag].place(message.chunk_offset),
                     message.offset);
}

double MessageStream::progress() const {
  // Chunks are of about one size.
  return chunks_.empty() ? 1.0 : static_cast<double>(next_chunk_) / static_cast<double>(chunks_.size());
}

}  // namespace waymark::rosbag1
