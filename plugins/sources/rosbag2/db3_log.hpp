// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "database.hpp"
#include "plugins/shared/compression/unpacked_file.hpp"
#include "plugins/shared/message_log/message_log.hpp"

namespace waymark::rosbag2 {

/// A part of a bag in SQLite's format. The record of a message is its row.
class Db3Log final : public message_log::MessageLog {
 public:
  /// Throws DataError.
  explicit Db3Log(const std::filesystem::path& file);

  const std::vector<message_log::Topic>& topics() const override { return topics_; }
  void select(std::set<std::size_t> topics) override;
  std::optional<message_log::Message> next(BadRecordList& bad) override;
  std::string place(const message_log::Message& message) const override;
  double progress() const override;

 private:
  void read_topics();

  compression::UnpackedFile file_;
  std::optional<Database> database_;
  std::vector<message_log::Topic> topics_;
  std::map<std::int64_t, std::size_t> topic_of_;  // by its number in the database
  std::optional<Rows> messages_;
  std::uint64_t selected_ = 0;
  std::uint64_t delivered_ = 0;
};

}  // namespace waymark::rosbag2
