// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include "waymark/api.hpp"

namespace waymark {

/// A fixed team of threads for loops over particles. The range is cut into equal parts in a fixed way, and a call
/// returns when all parts are done: a barrier. Not oneTBB: its run-time library hides its synchronisation from the
/// thread sanitizer, and these loops need no work stealing.
class WAYMARK_API Workers {
 public:
  /// `threads` >= 1 in total, the caller among them.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const { return static_cast<int>(team_.size()) + 1; }

  /// Calls body(i) for i in [0, count). `body` must not throw. Loops shorter than `serial_below` run on the caller
  /// alone: waking a thread costs more.
  void for_each(int count, const std::function<void(int)>& body, int serial_below = 8);

 private:
  void work(int member);
  void run_part(int member);

  std::vector<std::thread> team_;
  const std::function<void(int)>* body_ = nullptr;
  int count_ = 0;
  std::atomic<std::uint32_t> round_{0};
  std::atomic<int> busy_{0};
  std::atomic<bool> closing_{false};
};

}  // namespace waymark
