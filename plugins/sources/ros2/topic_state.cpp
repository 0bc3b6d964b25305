// SPDX-License-Identifier: Apache-2.0
#include "topic_state.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace waymark::ros2 {
namespace {

/// After so long without a publisher it is worth a look whether there is one of another type.
constexpr std::chrono::seconds kPatience{3};
constexpr std::uint64_t kStep = 10;

}  // namespace

void TopicState::look(const dds::Participant& participant, const dds::Reader& reader, live::EventList& events) {
  const bool is_connected = reader.writers() > 0;
  if (is_connected != is_connected_) {
    is_connected_ = is_connected;
    events.add(fmt::format("{}: {}", topic_,
                           !is_connected    ? "lost: nobody publishes it"
                           : was_connected_ ? "restored"
                                            : "connected"));
    was_connected_ = true;
  }
  if (const std::size_t refused = reader.refused_writers(); refused > refused_) {
    refused_ = refused;
    events.add(
        fmt::format("{}: a publisher offers less than is asked for, and is ignored: `reliable: true` needs one "
                    "that is",
                    topic_));
  }
  if (const std::uint64_t lost = reader.lost(); lost >= next_lost_) {
    events.add(fmt::format("{}: {} message{} lost so far", topic_, lost, lost == 1 ? " was" : "s were"));
    while (next_lost_ <= lost) next_lost_ *= kStep;
  }
  if (was_connected_ || is_type_reported_ || std::chrono::steady_clock::now() - since_ < kPatience) return;
  std::vector<std::string> types = participant.types_on(topic_, true);
  std::erase(types, type_);
  if (types.empty()) return;
  is_type_reported_ = true;
  events.add(fmt::format("{}: nobody publishes {}; there is {}", topic_, type_, fmt::join(types, ", ")));
}

}  // namespace waymark::ros2
