// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <utility>

namespace waymark {

/// A copy-on-write value. Copying costs one atomic increment. Different handles to one value may be read, written and
/// copied from different threads; one handle belongs to one thread at a time. (`std::shared_ptr::use_count` is a
/// relaxed read, too weak for writing in place; this count is read with acquire.)
template <class T>
class Cow {
 public:
  Cow() : box_(new Box{}) {}
  explicit Cow(T value) : box_(new Box{{1}, std::move(value)}) {}
  Cow(const Cow& other) noexcept : box_(other.box_) { box_->owners.fetch_add(1, std::memory_order_relaxed); }
  Cow(Cow&& other) noexcept : box_(std::exchange(other.box_, nullptr)) {}
  Cow& operator=(const Cow& other) noexcept {
    if (this != &other) *this = Cow(other);
    return *this;
  }
  Cow& operator=(Cow&& other) noexcept {
    std::swap(box_, other.box_);
    return *this;
  }
  ~Cow() { release(); }

  const T& read() const { return box_->value; }
  const T* operator->() const { return &box_->value; }

  /// The value for writing; clones it first if others share it.
  T& write() {
    if (box_->owners.load(std::memory_order_acquire) != 1) {
      Box* own = new Box{{1}, box_->value};
      release();
      box_ = own;
    }
    return box_->value;
  }

  /// True if another handle holds the same value.
  bool is_shared() const { return box_->owners.load(std::memory_order_acquire) != 1; }
  /// Identifies the shared value, for saving it once.
  const void* identity() const { return box_; }
  bool shares_with(const Cow& other) const { return box_ == other.box_; }

 private:
  struct Box {
    std::atomic<std::uint32_t> owners{1};
    T value{};
  };

  void release() {
    if (box_ != nullptr && box_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) delete box_;
  }

  Box* box_;
};

}  // namespace waymark
