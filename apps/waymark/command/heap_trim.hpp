// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

namespace waymark::command {

/// Returns memory that the allocator keeps free to the system, every ten seconds: a robot that runs for months does not
/// keep what its fullest queue needed. Takes 1 to 2 ms each time. Does nothing without the allocator of glibc.
class HeapTrim {
 public:
  HeapTrim();
  ~HeapTrim();
  HeapTrim(const HeapTrim&) = delete;
  HeapTrim& operator=(const HeapTrim&) = delete;

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable end_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace waymark::command
