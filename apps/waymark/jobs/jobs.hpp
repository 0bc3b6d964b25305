// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace waymark::jobs {

/// Does `work(0)` to `work(count - 1)`, one after the other on each of `jobs` threads, and calls `done` with how many
/// are finished (one call at a time). Work must not depend on which thread is sooner. The first error ends all and is
/// thrown.
void run_all(std::size_t count, int jobs, const std::function<void(std::size_t)>& work,
             const std::function<void(std::size_t)>& done);

}  // namespace waymark::jobs
