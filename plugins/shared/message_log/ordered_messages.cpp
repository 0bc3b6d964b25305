// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/message_log/ordered_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::message_log {

OrderedMessages::OrderedMessages(std::vector<Part> parts, Load load, std::uint64_t most_bytes)
    : parts_(std::move(parts)), load_(std::move(load)), most_bytes_(std::min(most_bytes, kMostBytes)) {
  std::ranges::stable_sort(parts_, {}, &Part::first);
}

void OrderedMessages::load_next(BadRecordList& bad) {
  LoadedPart loaded = load_(parts_[next_part_++], bad);
  if (loaded.messages.empty()) return;
  bytes_in_memory_ += loaded.bytes;
  if (bytes_in_memory_ > most_bytes_) {
    throw DataError(
        fmt::format("the parts of the recording that overlap in time unpack to more than {} bytes", most_bytes_));
  }
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
