// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "plugins/shared/dds/participant.hpp"

namespace waymark::dds {

/// Reads the samples of one topic.
class Reader {
 public:
  /// Throws Error.
  Reader(const Participant& participant, const std::string& topic, const std::string& type, const Quality& quality);
  Reader(Reader&&) = default;
  Reader& operator=(Reader&&) = delete;

  /// Appends what has arrived, in the order of arrival.
  void take(std::vector<Sample>& samples);

  Entity handle() const { return entity_.handle(); }
  /// Writers that it gets samples of.
  std::size_t writers() const;
  /// Writers whose samples it does not get, since they offer less than was asked for. Counts all since the start.
  std::size_t refused_writers() const;
  /// Samples that were lost on their way, and such that newer ones replaced before they were taken.
  std::uint64_t lost() const;

 private:
  std::shared_ptr<Losses> losses_;
  TopicEntity topic_;
  OwnedEntity entity_;
};

/// Waits for samples of several readers.
class Wait {
 public:
  /// Throws Error.
  explicit Wait(const Participant& participant);

  void add(const Reader& reader);
  /// Until there is something to take, `stop` was called, or the time is over.
  void wait(std::chrono::nanoseconds limit);
  /// Ends `wait`, now and from now on. By any thread.
  void stop();

 private:
  OwnedEntity stop_;
  OwnedEntity set_;
};

}  // namespace waymark::dds
