// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "flight_encoder.hpp"
#include "record_file.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::recorder {

/// What goes into a record.
struct Delivered {
  Measurement measurement;
  bool is_dropped = false;
};
struct Commanded {
  Time arrival;
  std::string text;
};
struct Attached {
  std::string name, media_type, content;
};
using Entry = std::variant<Delivered, Commanded, Attached>;

/// A record in the making. A thread of its own encodes and writes; adding costs a place in the queue and never waits
/// for the disk. A queue that is full, and a file that cannot be written, end the record early, with an event.
class Recording {
 public:
  /// `queue_bytes`: memory that waiting entries may keep. Throws Error if the file cannot be created.
  Recording(const std::filesystem::path& file, FlightEncoder encoder, std::size_t queue_bytes);
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  void add(Entry entry);
  /// From now on what is waiting is written after a second, even if nothing follows.
  void flush_when_idle() { flush_when_idle_ = true; }
  /// Writes what is waiting and ends the file.
  void finish();

  std::vector<std::string> take_events();

 private:
  struct Queued {
    Entry entry;
    std::size_t bytes;
  };

  void run();
  void encode(const Entry& entry);
  void write(std::vector<std::uint8_t> bytes);
  void end_early(const std::string& reason);

  RecordFile file_;
  FlightEncoder encoder_;
  const std::filesystem::path path_;
  const std::size_t queue_bytes_;
  std::atomic<bool> flush_when_idle_{false};

  std::mutex mutex_;  // of what follows
  std::condition_variable filled_;
  std::deque<Queued> queue_;
  std::size_t bytes_ = 0;      // in the queue
  bool is_ending_ = false;     // nothing is added any more
  std::string ended_because_;  // of an early end
  std::vector<std::string> events_;

  std::thread thread_;
};

}  // namespace waymark::recorder
