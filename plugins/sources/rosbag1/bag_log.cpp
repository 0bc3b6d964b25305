// SPDX-License-Identifier: Apache-2.0
#include "bag_log.hpp"

#include <utility>

#include "decompress.hpp"

namespace waymark::rosbag1 {
namespace {

std::vector<Bag> open(const std::vector<std::filesystem::path>& files) {
  std::vector<Bag> bags;
  bags.reserve(files.size());
  for (const std::filesystem::path& file : files) bags.emplace_back(file);
  return bags;
}

}  // namespace

BagLog::BagLog(const std::vector<std::filesystem::path>& bags) : ChunkedLog(open(bags)) {
  std::uint64_t size = 0;
  for (std::size_t bag = 0; bag < files().size(); ++bag) {
    size += files()[bag].size();
    for (const auto& [number, connection] : files()[bag].connections()) {
      message_log::Topic topic;
      topic.name = connection.topic;
      topic.type = connection.type;
      topic.encoding = message_log::Topic::Encoding::ros1;
      topic.encoding_name = "ros1";
      topic.md5 = connection.md5;
      topic.messages = files()[bag].messages(number);
      add_topic(bag, number, std::move(topic));
    }
  }
  most_bytes_ = 4 * most_unpacked(size);
}

std::string BagLog::read_messages(const Bytes& chunk, const NewMessage& new_message) const {
  const auto take = [&](const StoredMessage& stored) {
    message_log::Message* message = new_message(stored.connection);
    if (message == nullptr) return;
    message->recorded = stored.recorded;
    message->data = stored.data;
    message->offset = stored.offset;
  };
  return read_chunk(chunk, take, nullptr);
}

}  // namespace waymark::rosbag1
