// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <vector>

#include "waymark/base/time.hpp"

namespace waymark::ros {

static_assert(std::endian::native == std::endian::little, "arrays of numbers are copied as they lie in memory");

using Bytes = std::span<const std::uint8_t>;

/// Why a record or a message cannot be used. Never leaves a plugin.
class Unusable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A number as it lies in a message.
template <class T>
concept WireNumber = (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_same_v<T, std::byte>;

/// Reads numbers, texts and counts as ROS 1 or ROS 2 serializes them. Throws Unusable at the end of the bytes, which
/// must outlive this.
class WireReader {
 public:
  /// ROS 1, and records of its bags: little endian, without padding.
  explicit WireReader(Bytes bytes) : bytes_(bytes) {}
  /// ROS 2: XCDR1 (OMG DDS-XTypes 1.3, 7.4.1 and 7.6.2) of either byte order behind its encapsulation header of 4
  /// bytes. Throws Unusable for another encapsulation.
  static WireReader cdr(Bytes encapsulated) {
    WireReader header(encapsulated);
    const Bytes kind = header.take(4);
    if (kind[0] != 0 || kind[1] > 1) throw Unusable("its encapsulation is not plain CDR (XCDR1)");
    WireReader reader(encapsulated.subspan(4));
    reader.aligned_ = true;
    reader.swapped_ = kind[1] == 0;
    return reader;
  }

  bool is_cdr() const { return aligned_; }
  std::size_t left() const { return bytes_.size() - used_; }

  template <WireNumber T>
  T value() {
    align(sizeof(T));
    const Bytes bytes = take(sizeof(T));
    std::array<std::uint8_t, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes.data(), sizeof(T));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  /// Fills `values`; of one byte order they are copied as they are, NaN included.
  template <WireNumber T>
  void values(std::span<T> values) {
    if (values.empty()) return;
    align(sizeof(T));
    const Bytes bytes = take(values.size_bytes());
    std::memcpy(values.data(), bytes.data(), bytes.size());
    if (!swapped_) return;
    auto* const raw = reinterpret_cast<std::uint8_t*>(values.data());
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(T)) std::reverse(raw + i, raw + i + sizeof(T));
  }

  Bytes take(std::size_t count) {
    if (count > left()) throw Unusable("ends early");
    const Bytes taken = bytes_.subspan(used_, count);
    used_ += count;
    return taken;
  }

  /// A count of elements that need at least `least_size` bytes each. Throws Unusable if the bytes left cannot hold
  /// them, so that nobody allocates for them.
  std::size_t count(std::size_t least_size) {
    const std::size_t count = value<std::uint32_t>();
    if (count > left() / std::max<std::size_t>(least_size, 1)) throw Unusable("ends early");
    return count;
  }

  /// Bytes behind their count.
  Bytes counted() { return take(count(1)); }

  std::string_view text() {
    Bytes bytes = counted();
    // The zero that ends a text of CDR counts.
    if (aligned_ && !bytes.empty()) {
      if (bytes.back() != 0) throw Unusable("a text does not end with a zero");
      bytes = bytes.first(bytes.size() - 1);
    }
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  /// Time of ROS 1: unsigned seconds, nanoseconds.
  Time time() {
    const auto seconds = value<std::uint32_t>();
    const auto nanoseconds = value<std::uint32_t>();
    return Time{Duration{std::int64_t{seconds} * 1'000'000'000 + nanoseconds}};
  }

 private:
  void align(std::size_t size) {
    if (!aligned_) return;
    take((size - used_ % size) % size);
  }

  Bytes bytes_;
  std::size_t used_ = 0;
  bool aligned_ = false;
  bool swapped_ = false;
};

}  // namespace waymark::ros
