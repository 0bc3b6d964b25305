// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/mcap/mcap_log.hpp"

#include <cstdint>
#include <memory>
#include <utility>

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

Topic topic_of(const McapFile& file, std::uint16_t id, const Channel& channel) {
  Topic topic;
  topic.name = channel.topic;
  topic.encoding_name = channel.message_encoding;
  if (channel.message_encoding == "cdr") topic.encoding = Topic::Encoding::cdr;
  const auto schema = file.schemas().find(channel.schema_id);
  if (schema != file.schemas().end()) {
    topic.type = schema->second.name;
    if (schema->second.encoding == "ros2msg")
      topic.definition.assign(schema->second.data.begin(), schema->second.data.end());
  }
  topic.metadata.insert(channel.metadata.begin(), channel.metadata.end());
  const auto payload = topic.metadata.find(std::string(kPayloadKey));
  if (payload != topic.metadata.end()) topic.payload = payload->second;
  topic.messages = file.messages(id);
  return topic;
}

}  // namespace

McapLog::McapLog(const std::vector<std::filesystem::path>& files) : McapLog(open(files)) {}

McapLog::McapLog(std::vector<McapFile> opened) : ChunkedLog(std::move(opened)) {
  for (std::size_t file = 0; file < files().size(); ++file) {
    for (const auto& [id, channel] : files()[file].channels())
      add_topic(file, id, topic_of(files()[file], id, channel));
  }
}

std::string McapLog::read_messages(const Bytes& chunk, const NewMessage& new_message) const {
  const auto take = [&](const StoredMessage& stored) {
    message_log::Message* message = new_message(stored.message.channel_id);
    if (message == nullptr) return;
    message->recorded = to_time(stored.message.log_time);
    if (!topics()[message->topic].payload.empty()) message->published = to_time(stored.message.publish_time);
    message->sequence = stored.message.sequence;
    message->data = stored.message.data;
    message->offset = stored.offset;
  };
  return read_chunk(chunk, {take, nullptr, nullptr});
}

}  // namespace waymark::mcap
