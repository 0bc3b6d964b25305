// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "waymark/base/time.hpp"

namespace waymark::rosbag1 {

static_assert(std::endian::native == std::endian::little, "bags and ROS messages are little-endian");

using Bytes = std::span<const std::uint8_t>;

/// Why a record or a message cannot be used. Never leaves the plugin.
class Unusable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads what ROS serialized: little endian, without padding. Throws Unusable at the end of the bytes.
class Wire {
 public:
  explicit Wire(Bytes bytes) : rest_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> T value() {
    T result;
    std::memcpy(&result, take(sizeof result).data(), sizeof result);
    return result;
  }

  Bytes take(std::size_t count) {
    if (count > rest_.size()) throw Unusable("ends early");
    const Bytes taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }

  /// Bytes behind a count of 32 bits.
  Bytes counted() { return take(value<std::uint32_t>()); }

  std::string_view text() {
    const Bytes bytes = counted();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  /// Seconds and nanoseconds of 32 bits each.
  Time time() {
    const auto seconds = value<std::uint32_t>();
    const auto nanoseconds = value<std::uint32_t>();
    return Time{Duration{std::int64_t{seconds} * 1'000'000'000 + nanoseconds}};
  }

  std::size_t left() const { return rest_.size(); }

 private:
  Bytes rest_;
};

}  // namespace waymark::rosbag1
