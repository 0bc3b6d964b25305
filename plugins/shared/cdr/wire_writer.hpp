// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"

namespace waymark::ros {

/// Writes XCDR1, little endian, behind the encapsulation header. Throws std::length_error for a text or list of 2³²
/// elements or more.
class WireWriter {
 public:
  WireWriter() : bytes_{0, 1, 0, 0} {}

  template <WireNumber T>
  void value(T number) {
    values(std::span<const T>(&number, 1));
  }

  template <WireNumber T>
  void values(std::span<const T> numbers) {
    if (numbers.empty()) return;
    align(sizeof(T));
    raw(numbers.data(), numbers.size_bytes());
  }

  void count(std::size_t count) {
    if (count > std::numeric_limits<std::uint32_t>::max()) throw std::length_error("a list is too long for CDR");
    value(static_cast<std::uint32_t>(count));
  }

  void text(std::string_view text) {
    count(text.size() + 1);
    raw(text.data(), text.size());
    bytes_.push_back(0);
  }

  const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  std::vector<std::uint8_t> take() { return std::exchange(bytes_, {}); }

 private:
  static constexpr std::size_t kHeader = 4;

  void align(std::size_t size) {
    while ((bytes_.size() - kHeader) % size != 0) bytes_.push_back(0);
  }
  void raw(const void* data, std::size_t size) {
    const auto* const first = static_cast<const std::uint8_t*>(data);
    bytes_.insert(bytes_.end(), first, first + size);
  }

  std::vector<std::uint8_t> bytes_;
};

}  // namespace waymark::ros
