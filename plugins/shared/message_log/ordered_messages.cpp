// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/message_log/ordered_messages.hpp"

#include <algorithm>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::message_log {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30;

}  // namespace

OrderedMessages::OrderedMessages(std::vector<Part> parts, Load load)
    : parts_(std::move(parts)), load_(std::move(load)) {
  std::ranges::stable_sort(parts_, {}, &Part::first);
}

void OrderedMessages::load_next(BadRecordList& bad) {
  LoadedPart loaded = load_(parts_[next_part_++], bad);
  if (loaded.messages.empty()) return;
  bytes_in_memory_ += loaded.bytes;
  if (bytes_in_memory_ > kMostBytes)
    throw DataError("the parts of the recording overlap in time so much that more than 1 GiB would be in memory");
  const Message& first = loaded.messages.front();
  in_memory_[{first.file, first.record}] = {loaded.messages.size(), loaded.bytes};
  for (Message& message : loaded.messages) pending_.push(std::move(message));
}

std::optional<Message> OrderedMessages::next(BadRecordList& bad) {
  while (next_part_ < parts_.size() && (pending_.empty() || parts_[next_part_].first <= pending_.top().recorded))
    load_next(bad);
  if (pending_.empty()) return std::nullopt;
  Message message = pending_.top();
  pending_.pop();
  const auto part = in_memory_.find({message.file, message.record});
  if (--part->second.messages_left == 0) {
    bytes_in_memory_ -= part->second.bytes;
    in_memory_.erase(part);
  }
  return message;
}

double OrderedMessages::progress() const {
  // Parts are of about one size.
  return parts_.empty() ? 1.0 : static_cast<double>(next_part_) / static_cast<double>(parts_.size());
}

}  // namespace waymark::message_log
