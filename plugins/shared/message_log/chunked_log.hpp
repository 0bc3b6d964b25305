// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "plugins/shared/message_log/message_log.hpp"
#include "plugins/shared/message_log/ordered_messages.hpp"

namespace waymark::message_log {

/// Files of chunks that are read as one. A `File` (mcap::McapFile, rosbag1::Bag) lists its chunks, loads one of them,
/// and reports where it breaks off.
template <class File>
class ChunkedLog : public MessageLog {
 public:
  const std::vector<Topic>& topics() const override { return topics_; }

  std::string problem() const override {
    const auto broken = std::ranges::find_if(files_, [](const File& file) { return !file.broken_because().empty(); });
    return broken == files_.end() ? ""
                                  : fmt::format("{}: {}", broken->place(broken->broken_at()), broken->broken_because());
  }

  void select(std::set<std::size_t> topics) override {
    selected_ = std::move(topics);
    std::vector<Part> parts;
    for (std::size_t file = 0; file < files_.size(); ++file) {
      const auto& chunks = files_[file].chunks();
      for (std::size_t i = 0; i < chunks.size(); ++i) {
        const auto is_selected = [&](const auto& entry) { return selected_topic(file, entry.first).has_value(); };
        // One without any message may be damaged from its start on: that is to be reported.
        if (chunks[i].count.empty() || std::ranges::any_of(chunks[i].count, is_selected))
          parts.push_back({file, i, chunks[i].first});
      }
    }
    messages_.emplace(
        std::move(parts), [this](const Part& part, BadRecordList& bad) { return load(part, bad); }, most_bytes());
  }

  std::optional<Message> next(BadRecordList& bad) override {
    if (auto message = messages_->next(bad)) return message;
    while (next_ending_ < files_.size()) {
      const File& file = files_[next_ending_++];
      if (!file.broken_because().empty())
        bad.add(file.place(file.broken_at()), file.broken_because() + "; all that comes before it was read");
    }
    return std::nullopt;
  }

  std::string place(const Message& message) const override {
    return fmt::format("{}, message at byte {} of the chunk", files_[message.file].place(message.record),
                       message.offset);
  }

  double progress() const override { return messages_->progress(); }

  std::vector<File>& files() { return files_; }

 protected:
  using Bytes = std::vector<std::uint8_t>;
  /// A new message of a channel, to be filled; null if its topic is not selected. Valid until the next call.
  using NewMessage = std::function<Message*(std::uint32_t channel)>;

  explicit ChunkedLog(std::vector<File> files) : files_(std::move(files)) {}

  void add_topic(std::size_t file, std::uint32_t channel, Topic topic) {
    topic_of_[{file, channel}] = topics_.size();
    topics_.push_back(std::move(topic));
  }

 private:
  /// Reads the messages of a chunk: times, sequence, data and offset. Returns why it stopped before the end; empty if
  /// it did not.
  virtual std::string read_messages(const Bytes& chunk, const NewMessage& new_message) const = 0;
  /// What chunks that overlap in time may take in memory.
  virtual std::uint64_t most_bytes() const { return OrderedMessages::kMostBytes; }

  std::optional<std::size_t> selected_topic(std::size_t file, std::uint32_t channel) const {
    const auto topic = topic_of_.find({file, channel});
    if (topic == topic_of_.end() || !selected_.contains(topic->second)) return std::nullopt;
    return topic->second;
  }

  LoadedPart load(const Part& part, BadRecordList& bad) {
    File& file = files_[part.file];
    const auto& chunk = file.chunks()[part.number];
    const auto content = std::make_shared<const decltype(file.load(chunk))>(file.load(chunk));
    LoadedPart loaded;
    loaded.bytes = content->bytes.size();
    const std::string problem = read_messages(content->bytes, [&](std::uint32_t channel) -> Message* {
      const std::optional<std::size_t> topic = selected_topic(part.file, channel);
      if (!topic) return nullptr;
      Message& message = loaded.messages.emplace_back();
      message.topic = *topic;
      message.owner = content;
      message.file = part.file;
      message.record = chunk.offset;
      return &message;
    });
    if (!chunk.whole) return loaded;  // reported at the end
    if (!content->problem.empty() || !problem.empty()) {
      bad.add(file.place(chunk.offset),
              fmt::format("a chunk is damaged: {}", content->problem.empty() ? problem : content->problem));
    }
    return loaded;
  }

  std::vector<File> files_;
  std::vector<Topic> topics_;
  std::map<std::pair<std::size_t, std::uint32_t>, std::size_t> topic_of_;  // by file and channel
  std::set<std::size_t> selected_;
  std::optional<OrderedMessages> messages_;
  std::size_t next_ending_ = 0;  // of the files, whose end has not been looked at
};

}  // namespace waymark::message_log
