// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "plugins/shared/message_log/message_log.hpp"

namespace waymark::rosbag2 {

/// The parts of a bag as one, in order of the time of recording; equal times in the order of the parts.
class MergedLog final : public message_log::MessageLog {
 public:
  /// One part; of compressed messages each is unpacked here.
  struct Part {
    std::unique_ptr<message_log::MessageLog> log;
    bool compressed_messages = false;
  };

  explicit MergedLog(std::vector<Part> parts);

  const std::vector<message_log::Topic>& topics() const override { return topics_; }
  void select(std::set<std::size_t> topics) override;
  std::optional<message_log::Message> next(BadRecordList& bad) override;
  std::string place(const message_log::Message& message) const override;
  double progress() const override;

 private:
  struct Input {
    Part part;
    std::size_t first_topic = 0;
    bool is_read = false;
    std::optional<message_log::Message> head;
  };

  void advance(Input& input, BadRecordList& bad);

  std::vector<Input> inputs_;
  std::vector<message_log::Topic> topics_;
};

}  // namespace waymark::rosbag2
