// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "plugins/shared/dds/reader.hpp"
#include "plugins/shared/live/event_list.hpp"

namespace waymark::ros2 {

/// Reports what happens to a topic: publishers that come and go, ones that do not fit, messages that were lost.
class TopicState {
 public:
  TopicState(std::string topic, std::string type) : topic_(std::move(topic)), type_(std::move(type)) {}

  void look(const dds::Participant& participant, const dds::Reader& reader, live::EventList& events);

 private:
  std::string topic_, type_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  bool was_connected_ = false;
  bool is_connected_ = false;
  bool is_type_reported_ = false;
  std::size_t refused_ = 0;
  std::uint64_t next_lost_ = 1;
};

}  // namespace waymark::ros2
