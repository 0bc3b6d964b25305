// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "plugins/shared/dds/writer.hpp"

namespace waymark::ros2_publisher {

/// Writes samples in a thread of its own, so that who hands them over never waits for a slow reader. If too many bytes
/// wait, the oldest samples are left out.
class Publisher {
 public:
  explicit Publisher(std::size_t most_bytes);
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// `writer` must outlive the object.
  void send(dds::Writer& writer, std::vector<std::uint8_t> cdr, std::optional<Time> written = {});
  /// Writes what waits, for so long at most, and ends the thread.
  void finish(std::chrono::milliseconds limit);
  /// Samples that were left out.
  std::uint64_t left_out() const;

 private:
  struct Waiting {
    dds::Writer* writer;
    std::vector<std::uint8_t> cdr;
    std::optional<Time> written;
  };
  void run();

  std::size_t most_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable filled_, emptied_;
  std::deque<Waiting> waiting_;
  std::size_t bytes_ = 0;
  std::uint64_t left_out_ = 0;
  bool is_writing_ = false;
  bool stopped_ = false;
  std::thread thread_;  // last: it uses all others
};

}  // namespace waymark::ros2_publisher
