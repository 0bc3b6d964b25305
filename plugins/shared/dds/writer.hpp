// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "plugins/shared/dds/participant.hpp"
#include "waymark/base/time.hpp"

namespace waymark::dds {

/// Writes the samples of one topic. Safe to use from several threads.
class Writer {
 public:
  /// `patience`: how long a write waits if readers of a reliable topic are slow; then the sample is left out. Throws
  /// Error.
  Writer(const Participant& participant, const std::string& topic, const std::string& type, const Quality& quality,
         std::chrono::nanoseconds patience);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Writes a sample of CDR with its encapsulation header. `written`: time of writing that readers get; nothing: now.
  void write(std::vector<std::uint8_t> cdr, std::optional<Time> written = {});
  /// Waits until all readers have what was written, or the time is over.
  void wait_for_readers(std::chrono::nanoseconds limit);

  /// Readers that get its samples.
  std::size_t readers() const;
  /// Samples that were left out since readers were slow.
  std::uint64_t left_out() const { return left_out_; }

 private:
  TopicEntity topic_;
  OwnedEntity entity_;
  std::atomic<std::uint64_t> left_out_ = 0;
};

}  // namespace waymark::dds
