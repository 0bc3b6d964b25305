// SPDX-License-Identifier: Apache-2.0
#include "particles/workers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

#include "waymark/base/error.hpp"

namespace waymark::particles {

namespace {

/// Waits until `value` differs from `old`: spins for some ten microseconds, since loops follow each other closely and
/// waking a thread takes longer than many of them; then sleeps.
template <class T>
T await_change(const std::atomic<T>& value, T old, int spin_rounds) {
  for (int round = 0; round < spin_rounds; ++round) {
    if (const T now = value.load(std::memory_order_acquire); now != old) return now;
#if defined(__x86_64__) || defined(__i386__)
    _mm_pause();
#endif
  }
  value.wait(old, std::memory_order_acquire);
  return value.load(std::memory_order_acquire);
}

/// Parts per thread if all are equally long. More cost more synchronisation; with fewer, one thread waits longer for
/// another with longer ones.
constexpr int kPartsEach = 4;

/// With more threads than processors a spinning thread would keep another from working.
int spin_rounds(int threads) { return threads <= static_cast<int>(std::thread::hardware_concurrency()) ? 2000 : 0; }

}  // namespace

Workers::Workers(int threads) : spin_rounds_(spin_rounds(threads)) {
  try {
    for (int member = 1; member < threads; ++member) team_.emplace_back([this] { work(); });
  } catch (const std::exception& error) {
    const std::size_t started = team_.size() + 1;
    close();
    throw Error(fmt::format("only {} of {} threads can be started: {}", started, threads, error.what()));
  }
}

Workers::~Workers() { close(); }

void Workers::close() {
  closing_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& thread : team_) thread.join();
}

void Workers::take_parts() {
  for (int first = next_.fetch_add(part_, std::memory_order_relaxed); first < count_;
       first = next_.fetch_add(part_, std::memory_order_relaxed)) {
    const int last = std::min(count_, first + part_);
    for (int i = first; i < last; ++i) (*body_)(i);
  }
}

void Workers::work() {
  std::uint32_t seen = 0;
  while (true) {
    seen = await_change(round_, seen, spin_rounds_);
    if (closing_.load(std::memory_order_relaxed)) return;
    take_parts();
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
  part_ = std::max(1, count / (kPartsEach * threads()));
  next_.store(0, std::memory_order_relaxed);
  busy_.store(static_cast<int>(team_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  take_parts();
  for (int left = busy_.load(std::memory_order_acquire); left != 0;) left = await_change(busy_, left, spin_rounds_);
}

}  // namespace waymark::particles
