// SPDX-License-Identifier: Apache-2.0
// Tables: ros2/rosbag2, rosbag2_storage_sqlite3/src/rosbag2_storage_sqlite3/sqlite_storage.cpp. Older bags lack some of
// them.
#include "db3_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::rosbag2 {

using message_log::Topic;

Db3Log::Db3Log(const std::filesystem::path& file) : file_(file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file_.path(), ignored))
    throw DataError(fmt::format("{}: cannot be read: there is no such file", file_.name().string()));
  try {
    database_.emplace(file_.path());
    read_topics();
  } catch (const ros::Unusable& unusable) {
    throw DataError(fmt::format("{}: is not a bag of ROS 2: {}", file_.name().string(), unusable.what()));
  }
}

void Db3Log::read_topics() {
  for (const char* column : {"id", "name", "type", "serialization_format"}) {
    if (!database_->has_column("topics", column))
      throw ros::Unusable(fmt::format("there is no table \"topics\" with the column \"{}\"", column));
  }
  for (const char* column : {"id", "topic_id", "timestamp", "data"}) {
    if (!database_->has_column("messages", column))
      throw ros::Unusable(fmt::format("there is no table \"messages\" with the column \"{}\"", column));
  }
  for (Rows rows = database_->rows("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
       rows.next();) {
    Topic topic;
    topic.name = rows.text(1);
    topic.type = rows.text(2);
    topic.encoding_name = rows.text(3);
    if (topic.encoding_name == "cdr") topic.encoding = Topic::Encoding::cdr;
    if (topic_of_.try_emplace(rows.number(0), topics_.size()).second) topics_.push_back(std::move(topic));
  }
  for (Rows rows = database_->rows("SELECT topic_id, count(*) FROM messages GROUP BY topic_id"); rows.next();) {
    const auto topic = topic_of_.find(rows.number(0));
    if (topic != topic_of_.end()) topics_[topic->second].messages = static_cast<std::uint64_t>(rows.number(1));
  }
  if (!database_->has_column("message_definitions", "encoded_message_definition")) return;
  for (Rows rows = database_->rows("SELECT topic_type, encoded_message_definition FROM message_definitions "
                                   "WHERE encoding = 'ros2msg'");
       rows.next();) {
    for (Topic& topic : topics_) {
      if (topic.type == rows.text(0)) topic.definition = rows.text(1);
    }
  }
}

void Db3Log::select(std::set<std::size_t> topics) {
  std::vector<std::int64_t> numbers;
  for (const auto& [number, topic] : topic_of_) {
    if (!topics.contains(topic)) continue;
    numbers.push_back(number);
    selected_ += topics_[topic].messages;
  }
  try {
    messages_.emplace(
        database_->rows(fmt::format("SELECT topic_id, timestamp, id, data FROM messages WHERE topic_id "
                                    "IN ({}) ORDER BY timestamp, id",
                                    fmt::join(numbers, ", "))));
  } catch (const ros::Unusable& unusable) {
    throw DataError(fmt::format("{}: is not a bag of ROS 2: {}", file_.name().string(), unusable.what()));
  }
}

std::optional<message_log::Message> Db3Log::next(BadRecordList& bad) {
  if (!messages_) return std::nullopt;
  try {
    if (messages_->next()) {
      const ros::Bytes data = messages_->bytes(3);
      const auto owner = std::make_shared<const std::vector<std::uint8_t>>(data.begin(), data.end());
      message_log::Message message;
      message.recorded = Time{Duration{messages_->number(1)}};
      message.topic = topic_of_.at(messages_->number(0));
      message.data = *owner;
      message.owner = owner;
      message.record = static_cast<std::uint64_t>(messages_->number(2));
      ++delivered_;
      return message;
    }
  } catch (const ros::Unusable& unusable) {
    messages_.reset();
    bad.add(file_.name().string(), fmt::format("cannot be read on: {}", unusable.what()));
  }
  messages_.reset();
  return std::nullopt;
}

std::string Db3Log::place(const message_log::Message& message) const {
  return fmt::format("{}:message {}", file_.name().string(), message.record);
}

double Db3Log::progress() const {
  return selected_ == 0 ? 1.0 : std::min(1.0, static_cast<double>(delivered_) / static_cast<double>(selected_));
}

}  // namespace waymark::rosbag2
