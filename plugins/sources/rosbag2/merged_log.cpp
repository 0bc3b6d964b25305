// SPDX-License-Identifier: Apache-2.0
#include "merged_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plugins/shared/compression/zstd_frame.hpp"

namespace waymark::rosbag2 {
namespace {

constexpr std::size_t kLargestMessage = std::size_t{1} << 28;

}  // namespace

MergedLog::MergedLog(std::vector<Part> parts) {
  for (Part& part : parts) {
    const std::size_t first = topics_.size();
    topics_.insert(topics_.end(), part.log->topics().begin(), part.log->topics().end());
    inputs_.push_back({std::move(part), first, false, std::nullopt});
  }
}

void MergedLog::select(std::set<std::size_t> topics) {
  for (Input& input : inputs_) {
    std::set<std::size_t> own;
    for (const std::size_t topic : topics) {
      if (topic >= input.first_topic && topic - input.first_topic < input.part.log->topics().size())
        own.insert(topic - input.first_topic);
    }
    input.part.log->select(std::move(own));
  }
}

/// Reads the next message of a part.
void MergedLog::advance(Input& input, BadRecordList& bad) {
  input.is_read = true;
  while ((input.head = input.part.log->next(bad))) {
    message_log::Message& message = *input.head;
    if (input.part.compressed_messages) {
      compression::Decompressed unpacked = compression::decompress_zstd(message.data, kLargestMessage);
      if (!unpacked.problem.empty() || unpacked.bytes.size() > kLargestMessage) {
        bad.add(input.part.log->place(message),
                unpacked.problem.empty() ? "a message of more than 256 MB" : unpacked.problem);
        continue;
      }
      const auto owner = std::make_shared<const std::vector<std::uint8_t>>(std::move(unpacked.bytes));
      message.data = *owner;
      message.owner = owner;
    }
    message.topic += input.first_topic;
    message.file = static_cast<std::size_t>(&input - inputs_.data());
    return;
  }
}

std::optional<message_log::Message> MergedLog::next(BadRecordList& bad) {
  Input* earliest = nullptr;
  for (Input& input : inputs_) {
    if (!input.is_read) advance(input, bad);
    if (input.head && (earliest == nullptr || input.head->recorded < earliest->head->recorded)) earliest = &input;
  }
  if (earliest == nullptr) return std::nullopt;
  earliest->is_read = false;
  return std::exchange(earliest->head, std::nullopt);
}

std::string MergedLog::place(const message_log::Message& message) const {
  const Input& input = inputs_[message.file];
  message_log::Message own = message;
  own.topic -= input.first_topic;
  own.file = 0;
  return input.part.log->place(own);
}

double MergedLog::progress() const {
  double sum = 0.0;
  for (const Input& input : inputs_) sum += input.part.log->progress();
  return inputs_.empty() ? 1.0 : sum / static_cast<double>(inputs_.size());
}

}  // namespace waymark::rosbag2
