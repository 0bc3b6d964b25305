// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/mcap/mcap_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "plugins/shared/compression/unpacked_file.hpp"

namespace waymark::mcap {
namespace {

using message_log::Topic;

std::vector<McapFile> open(const std::vector<std::filesystem::path>& files) {
  std::vector<McapFile> opened;
  opened.reserve(files.size());
  for (const std::filesystem::path& file : files) {
    const compression::UnpackedFile unpacked(file);
    opened.emplace_back(std::make_unique<FileBytes>(unpacked.path()), file.string());
  }
  return opened;
}

}  // namespace

McapLog::McapLog(const std::vector<std::filesystem::path>& files) : McapLog(open(files)) {}

McapLog::McapLog(std::vector<McapFile> files) : files_(std::move(files)) {
  for (std::size_t file = 0; file < files_.size(); ++file) add_topics(file);
}

void McapLog::add_topics(std::size_t file) {
  for (const auto& [id, channel] : files_[file].channels()) {
    Topic topic;
    topic.name = channel.topic;
    topic.encoding_name = channel.message_encoding;
    if (channel.message_encoding == "cdr") topic.encoding = Topic::Encoding::cdr;
    const auto schema = files_[file].schemas().find(channel.schema_id);
    if (schema != files_[file].schemas().end()) {
      topic.type = schema->second.name;
      if (schema->second.encoding == "ros2msg")
        topic.definition.assign(schema->second.data.begin(), schema->second.data.end());
    }
    topic.metadata.insert(channel.metadata.begin(), channel.metadata.end());
    const auto payload = topic.metadata.find(std::string(kPayloadKey));
    if (payload != topic.metadata.end()) topic.payload = payload->second;
    topic.messages = files_[file].messages(id);
    topic_of_[{file, id}] = topics_.size();
    topics_.push_back(std::move(topic));
  }
}

void McapLog::select(std::set<std::size_t> topics) {
  selected_ = std::move(topics);
  std::vector<message_log::Part> parts;
  for (std::size_t file = 0; file < files_.size(); ++file) {
    const std::vector<StoredChunk>& chunks = files_[file].chunks();
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      // One without any message may be damaged from its start on: that is to be reported.
      const auto is_wanted = [&](const auto& entry) {
        const auto topic = topic_of_.find({file, entry.first});
        return topic != topic_of_.end() && selected_.contains(topic->second);
      };
      if (chunks[i].count.empty() || std::ranges::any_of(chunks[i].count, is_wanted))
        parts.push_back({file, i, chunks[i].first});
    }
  }
  messages_.emplace(std::move(parts),
                    [this](const message_log::Part& part, BadRecordList& bad) { return load(part, bad); });
}

std::string McapLog::problem() const {
  const auto broken = std::ranges::find_if(files_, [](const McapFile& file) { return !file.broken_because().empty(); });
  return broken == files_.end() ? ""
                                : fmt::format("{}: {}", broken->place(broken->broken_at()), broken->broken_because());
}

message_log::LoadedPart McapLog::load(const message_log::Part& part, BadRecordList& bad) {
  McapFile& file = files_[part.file];
  const StoredChunk& chunk = file.chunks()[part.number];
  const auto content = std::make_shared<const ChunkContent>(file.load(chunk));
  message_log::LoadedPart loaded;
  loaded.bytes = content->bytes.size();
  const auto take = [&](const StoredMessage& stored) {
    const auto topic = topic_of_.find({part.file, stored.message.channel_id});
    if (topic == topic_of_.end() || !selected_.contains(topic->second)) return;
    message_log::Message message;
    message.recorded = to_time(stored.message.log_time);
    if (!topics_[topic->second].payload.empty()) message.published = to_time(stored.message.publish_time);
    message.sequence = stored.message.sequence;
    message.topic = topic->second;
    message.data = stored.message.data;
    message.owner = content;
    message.file = part.file;
    message.record = chunk.offset;
    message.offset = stored.offset;
    loaded.messages.push_back(std::move(message));
  };
  const std::string problem = read_chunk(content->bytes, {take, nullptr, nullptr});
  if (!chunk.whole) return loaded;  // reported at the end
  if (!content->problem.empty() || !problem.empty()) {
    bad.add(file.place(chunk.offset),
            fmt::format("a chunk is damaged: {}", content->problem.empty() ? problem : content->problem));
  }
  return loaded;
}

std::optional<message_log::Message> McapLog::next(BadRecordList& bad) {
  if (auto message = messages_->next(bad)) return message;
  while (next_ending_ < files_.size()) {
    const McapFile& file = files_[next_ending_++];
    if (!file.broken_because().empty())
      bad.add(file.place(file.broken_at()), file.broken_because() + "; all that comes before it was read");
  }
  return std::nullopt;
}

std::string McapLog::place(const message_log::Message& message) const {
  return fmt::format("{}, message at byte {} of the chunk", files_[message.file].place(message.record), message.offset);
}

}  // namespace waymark::mcap
