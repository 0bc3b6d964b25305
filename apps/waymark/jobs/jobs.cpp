// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/jobs/jobs.hpp"

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace waymark::jobs {

void run_all(std::size_t count, int jobs, const std::function<void(std::size_t)>& work,
             const std::function<void(std::size_t)>& done) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t finished = 0;
  std::exception_ptr failure;
  const auto worker = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
      const std::scoped_lock lock(mutex);
      done(++finished);
    }
  };
  {
    std::vector<std::jthread> threads;
    threads.reserve(static_cast<std::size_t>(jobs));
    for (int i = 0; i < jobs; ++i) threads.emplace_back(worker);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace waymark::jobs
