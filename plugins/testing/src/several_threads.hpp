// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace waymark::testing {

/// Calls body(i) once for every i in [0, count), from four threads at once. `body` must not throw.
template <class Body>
void on_several_threads(int count, const Body& body) {
  std::atomic<int> next = 0;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) body(i);
  };
  std::vector<std::jthread> team;
  team.reserve(3);
  for (int i = 0; i < 3; ++i) team.emplace_back(work);
  work();
}

}  // namespace waymark::testing
