// SPDX-License-Identifier: Apache-2.0
#include "bag_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "decompress.hpp"

namespace waymark::rosbag1 {

BagLog::BagLog(const std::vector<std::filesystem::path>& files) {
  bags_.reserve(files.size());
  for (const std::filesystem::path& file : files) bags_.emplace_back(file);
  for (std::size_t bag = 0; bag < bags_.size(); ++bag) {
    for (const auto& [number, connection] : bags_[bag].connections()) {
      message_log::Topic topic;
      topic.name = connection.topic;
      topic.type = connection.type;
      topic.encoding = message_log::Topic::Encoding::ros1;
      topic.encoding_name = "ros1";
      topic.md5 = connection.md5;
      topic.messages = bags_[bag].messages(number);
      topic_of_[{bag, number}] = topics_.size();
      topics_.push_back(std::move(topic));
    }
  }
}

std::string BagLog::problem() const {
  for (const Bag& bag : bags_) {
    if (!bag.broken_because().empty()) return fmt::format("{}: {}", bag.place(bag.broken_at()), bag.broken_because());
  }
  return "";
}

void BagLog::select(std::set<std::size_t> topics) {
  selected_ = std::move(topics);
  std::vector<message_log::Part> parts;
  for (std::size_t bag = 0; bag < bags_.size(); ++bag) {
    const std::vector<Chunk>& chunks = bags_[bag].chunks();
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      // One without any message is damaged from its start on: that is to be reported.
      const auto is_wanted = [&](const auto& entry) {
        const auto topic = topic_of_.find({bag, entry.first});
        return topic != topic_of_.end() && selected_.contains(topic->second);
      };
      if (chunks[i].count.empty() || std::ranges::any_of(chunks[i].count, is_wanted))
        parts.push_back({bag, i, chunks[i].first});
    }
  }
  std::uint64_t size = 0;
  for (const Bag& bag : bags_) size += bag.size();
  messages_.emplace(
      std::move(parts), [this](const message_log::Part& part, BadRecordList& bad) { return load(part, bad); },
      4 * most_unpacked(size));
}

message_log::LoadedPart BagLog::load(const message_log::Part& part, BadRecordList& bad) {
  Bag& bag = bags_[part.file];
  const Chunk& chunk = bag.chunks()[part.number];
  const auto content = std::make_shared<const ChunkContent>(bag.load(chunk));
  message_log::LoadedPart loaded;
  loaded.bytes = content->bytes.size();
  const std::string problem = read_chunk(
      content->bytes,
      [&](const StoredMessage& stored) {
        const auto topic = topic_of_.find({part.file, stored.connection});
        if (topic == topic_of_.end() || !selected_.contains(topic->second)) return;
        message_log::Message message;
        message.recorded = stored.recorded;
        message.topic = topic->second;
        message.data = stored.data;
        message.owner = content;
        message.file = part.file;
        message.record = chunk.offset;
        message.offset = stored.offset;
        loaded.messages.push_back(std::move(message));
      },
      nullptr);
  if (!chunk.whole) return loaded;  // reported at the end
  if (!content->problem.empty()) {
    bad.add(bag.place(chunk.offset), fmt::format("a chunk is damaged: {}", content->problem));
  } else if (!problem.empty()) {
    bad.add(bag.place(chunk.offset), fmt::format("a chunk is damaged: {}", problem));
  }
  return loaded;
}

std::optional<message_log::Message> BagLog::next(BadRecordList& bad) {
  if (auto message = messages_->next(bad)) return message;
  while (next_ending_ < bags_.size()) {
    const Bag& bag = bags_[next_ending_++];
    if (!bag.broken_because().empty())
      bad.add(bag.place(bag.broken_at()), bag.broken_because() + "; all that comes before it was read");
  }
  return std::nullopt;
}

std::string BagLog::place(const message_log::Message& message) const {
  return fmt::format("{}, message at byte {} of the chunk", bags_[message.file].place(message.record), message.offset);
}

}  // namespace waymark::rosbag1
