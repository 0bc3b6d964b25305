// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>

namespace waymark::feature_map {

/// The discrete distribution that describes how a landmark looks (4.7): hue and saturation in an image, reflectivity in
/// two bins (dark, bright), an identity in one bin each. Without bins it is unknown: never measured. Its storage
/// lies inside, so that no detection needs the heap.
class Signature {
 public:
  static constexpr std::size_t kMaxBins = 128;

  constexpr Signature() = default;
  constexpr Signature(std::initializer_list<float> bins) {
    for (const float bin : bins) bins_[size_++] = bin;
  }
  /// `size` <= kMaxBins equal bins.
  static Signature uniform(std::size_t size) {
    Signature signature;
    signature.size_ = size;
    std::fill_n(signature.bins_.begin(), size, 1.0f / static_cast<float>(size));
    return signature;
  }
  /// The distribution after reading `identity`: 1 − misreading_probability for its bin, the rest shared by the others.
  /// A negative identity, nothing read, is uniform.
  static Signature of_identity(int identity, int bins, double misreading_probability) {
    Signature signature = uniform(static_cast<std::size_t>(bins));
    if (identity < 0) return signature;
    const auto other = static_cast<float>(misreading_probability / (bins - 1));
    std::fill(signature.begin(), signature.end(), other);
    signature[static_cast<std::size_t>(identity)] = static_cast<float>(1.0 - misreading_probability);
    return signature;
  }

  constexpr std::size_t size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }  ///< unknown
  constexpr float operator[](std::size_t bin) const { return bins_[bin]; }
  constexpr float& operator[](std::size_t bin) { return bins_[bin]; }
  const float* begin() const { return bins_.data(); }
  const float* end() const { return bins_.data() + size_; }
  float* begin() { return bins_.data(); }
  float* end() { return bins_.data() + size_; }

 private:
  std::array<float, kMaxBins> bins_{};
  std::size_t size_ = 0;
};

}  // namespace waymark::feature_map
