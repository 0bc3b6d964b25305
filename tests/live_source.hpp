// SPDX-License-Identifier: Apache-2.0
// What the tests of live sources and sinks share: a thread that reads, free ports, patience.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "waymark/interface/source.hpp"

namespace waymark::test {

/// Waits until it is true; false if it is not within the time.
inline bool eventually(const std::function<bool()>& is_true,
                       std::chrono::milliseconds limit = std::chrono::seconds(20)) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!is_true()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// A port of this machine that nobody uses now. `type`: SOCK_STREAM or SOCK_DGRAM.
inline std::uint16_t free_port(int type) {
  const int probe = ::socket(AF_INET, type | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const bool good = ::bind(probe, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                    ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  ::close(probe);
  if (!good) throw std::runtime_error("there is no free port");
  return ntohs(address.sin_port);
}

/// True if `once`, which sets something up and returns how long its end took, is quick in one of five attempts: a busy
/// machine delays a thread now and then; code that waits for something else is slow every time.
inline bool ends_soon(const std::function<std::chrono::steady_clock::duration()>& once) {
  constexpr auto kSoon = std::chrono::milliseconds(500);  // 0.1 s, and what a busy machine adds
  constexpr int kAttempts = 5;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (once() < kSoon) return true;
  }
  return false;
}

/// Reads a live source in a thread of its own, as the host does.
class LiveReader {
 public:
  explicit LiveReader(std::shared_ptr<Source> source) : source_(std::move(source)), thread_([this] { read(); }) {}
  ~LiveReader() { stop(); }
  LiveReader(const LiveReader&) = delete;
  LiveReader& operator=(const LiveReader&) = delete;

  /// Ends the thread; how long that took.
  std::chrono::steady_clock::duration stop() {
    const auto start = std::chrono::steady_clock::now();
    source_->stop();
    if (thread_.joinable()) thread_.join();
    return std::chrono::steady_clock::now() - start;
  }
  bool wait_for(std::size_t count) const {
    return eventually([&] { return measurements().size() >= count; });
  }
  bool wait_for_end() const {
    return eventually([&] { return ended_.load(); });
  }
  /// Waits for an event that contains the text.
  bool wait_for_event(const std::string& text) {
    return eventually([&] {
      for (std::string& event : source_->take_events()) events_.push_back(std::move(event));
      for (const std::string& event : events_) {
        if (event.find(text) != std::string::npos) return true;
      }
      return false;
    });
  }
  std::vector<Measurement> measurements() const {
    const std::lock_guard lock(mutex_);
    return measurements_;
  }
  const std::vector<std::string>& events() const { return events_; }
  /// Message of the exception that ended the thread; empty if there was none. After the end.
  const std::string& failure() const { return failure_; }
  Source& source() { return *source_; }

 private:
  void read() {
    try {
      while (auto measurement = source_->next()) {
        const std::lock_guard lock(mutex_);
        measurements_.push_back(std::move(*measurement));
      }
    } catch (const std::exception& error) {
      failure_ = error.what();
    }
    ended_ = true;
  }

  std::shared_ptr<Source> source_;
  mutable std::mutex mutex_;
  std::vector<Measurement> measurements_;
  std::vector<std::string> events_;
  std::string failure_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

}  // namespace waymark::test
