// SPDX-License-Identifier: Apache-2.0
#include "waymark/workers.hpp"

namespace waymark {

Workers::Workers(int threads) {
  for (int member = 1; member < threads; ++member) {
    team_.emplace_back([this, member] { work(member); });
  }
}

Workers::~Workers() {
  closing_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& thread : team_) thread.join();
}

void Workers::run_part(int member) {
  const std::int64_t parts = threads();
  const int first = static_cast<int>(count_ * std::int64_t{member} / parts);
  const int last = static_cast<int>(count_ * (std::int64_t{member} + 1) / parts);
  for (int i = first; i < last; ++i) (*body_)(i);
}

void Workers::work(int member) {
  std::uint32_t seen = 0;
  while (true) {
    round_.wait(seen, std::memory_order_acquire);
    seen = round_.load(std::memory_order_acquire);
    if (closing_.load(std::memory_order_relaxed)) return;
    run_part(member);
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_one();
  }
}

void Workers::for_each(int count, const std::function<void(int)>& body, int serial_below) {
  if (team_.empty() || count < serial_below) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  body_ = &body;
  count_ = count;
  busy_.store(static_cast<int>(team_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  run_part(0);
  for (int left = busy_.load(std::memory_order_acquire); left != 0; left = busy_.load(std::memory_order_acquire)) {
    busy_.wait(left, std::memory_order_acquire);
  }
}

}  // namespace waymark
