// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bag.hpp"
#include "plugins/shared/message_log/message_log.hpp"
#include "plugins/shared/message_log/ordered_messages.hpp"

namespace waymark::rosbag1 {

/// Bags that are read as one.
class BagLog final : public message_log::MessageLog {
 public:
  /// Throws DataError.
  explicit BagLog(const std::vector<std::filesystem::path>& files);

  const std::vector<message_log::Topic>& topics() const override { return topics_; }
  std::string problem() const override;
  void select(std::set<std::size_t> topics) override;
  std::optional<message_log::Message> next(BadRecordList& bad) override;
  std::string place(const message_log::Message& message) const override;
  double progress() const override { return messages_->progress(); }

 private:
  message_log::LoadedPart load(const message_log::Part& part, BadRecordList& bad);

  std::vector<Bag> bags_;
  std::vector<message_log::Topic> topics_;
  std::map<std::pair<std::size_t, std::uint32_t>, std::size_t> topic_of_;  // bag and connection
  std::set<std::size_t> selected_;
  std::optional<message_log::OrderedMessages> messages_;
  std::size_t next_ending_ = 0;  // of the bags, whose end has not been looked at
};

}  // namespace waymark::rosbag1
