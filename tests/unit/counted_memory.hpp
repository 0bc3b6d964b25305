// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

// Counts every allocation of the process. For one source file of a program only: it defines operators new and delete.

namespace waymark::counted {
inline std::atomic<long> allocations{0};
inline std::atomic<std::size_t> bytes{0};  ///< asked for, whether given back or not
}  // namespace waymark::counted

// NOLINTBEGIN: these are the global operators; inlined, GCC sees malloc behind new and delete and finds them mismatched
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++waymark::counted::allocations;
  waymark::counted::bytes += size;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++waymark::counted::allocations;
  waymark::counted::bytes += size;
  return std::malloc(size == 0 ? 1 : size);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++waymark::counted::allocations;
  waymark::counted::bytes += size;
  const auto a = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(a, (size + a - 1) / a * a)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
// NOLINTEND
