// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include "waymark/base/api.hpp"

namespace waymark::particles {

/// A fixed team of threads for loops over particles. Each thread takes the next few indices when it has finished its
/// last, and a call returns when all are finished: a barrier. The result of body(i) must not depend on the thread. Not
/// oneTBB: its run-time library hides its synchronisation from the thread sanitizer, and these loops need no work
/// stealing.
class WAYMARK_API Workers {
 public:
  /// `threads` >= 1 in total, the caller among them. Throws Error if the system cannot start so many.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const { return static_cast<int>(team_.size()) + 1; }

  /// Calls body(i) for i in [0, count). `body` must not throw. Loops shorter than `serial_below` run on the caller
  /// alone: waking a thread costs more.
  void for_each(int count, const std::function<void(int)>& body, int serial_below = 8);

 private:
  void work();
  void close();
  void take_parts();

  int spin_rounds_;
  std::vector<std::thread> team_;
  const std::function<void(int)>* body_ = nullptr;
  int count_ = 0;
  int part_ = 1;              // number of indices that a thread takes at once
  std::atomic<int> next_{0};  // the first that no thread has taken
  std::atomic<std::uint32_t> round_{0};
  std::atomic<int> busy_{0};
  std::atomic<bool> closing_{false};
};

}  // namespace waymark::particles
