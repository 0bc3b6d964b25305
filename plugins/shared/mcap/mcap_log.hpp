// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "plugins/shared/mcap/file.hpp"
#include "plugins/shared/message_log/message_log.hpp"
#include "plugins/shared/message_log/ordered_messages.hpp"

namespace waymark::mcap {

/// Keys of a channel's metadata in files that waymark writes.
inline constexpr std::string_view kSensorKey = "waymark.sensor";    ///< name in the YAML
inline constexpr std::string_view kPayloadKey = "waymark.payload";  ///< "waymark/LaserScan@1"
inline constexpr std::string_view kRoleKey = "waymark.role";        ///< one of the following
inline constexpr std::string_view kMeasurementRole = "measurement";
inline constexpr std::string_view kDroppedRole = "dropped";
inline constexpr std::string_view kCommandRole = "command";
/// The sequence number of the channel's first message, as a decimal number of 64 bits. A message has only 32 of them.
inline constexpr std::string_view kFirstSequenceKey = "waymark.first_sequence";

/// MCAP files that are read as one.
class McapLog final : public message_log::MessageLog {
 public:
  /// Opens the files, which may be packed as a whole (.gz, .zst, .zstd). Throws DataError.
  explicit McapLog(const std::vector<std::filesystem::path>& files);
  explicit McapLog(std::vector<McapFile> files);

  const std::vector<message_log::Topic>& topics() const override { return topics_; }
  std::string problem() const override;
  void select(std::set<std::size_t> topics) override;
  std::optional<message_log::Message> next(BadRecordList& bad) override;
  std::string place(const message_log::Message& message) const override;
  double progress() const override { return messages_->progress(); }

  std::vector<McapFile>& files() { return files_; }

 private:
  void add_topics(std::size_t file);
  message_log::LoadedPart load(const message_log::Part& part, BadRecordList& bad);

  std::vector<McapFile> files_;
  std::vector<message_log::Topic> topics_;
  std::map<std::pair<std::size_t, std::uint16_t>, std::size_t> topic_of_;  // file and channel
  std::set<std::size_t> selected_;
  std::optional<message_log::OrderedMessages> messages_;
  std::size_t next_ending_ = 0;  // of the files, whose end has not been looked at
};

}  // namespace waymark::mcap
