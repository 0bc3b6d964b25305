// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/heap_trim.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <chrono>

#include "plugins/shared/live/thread_without_signals.hpp"

namespace waymark::command {

HeapTrim::HeapTrim() : thread_(live::thread_without_signals([this] { run(); })) {}

HeapTrim::~HeapTrim() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  end_.notify_one();
  thread_.join();
}

void HeapTrim::run() {
  constexpr std::chrono::seconds kEvery{10};
  std::unique_lock lock(mutex_);
  while (!end_.wait_for(lock, kEvery, [this] { return ends_; })) {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
  }
}

}  // namespace waymark::command
