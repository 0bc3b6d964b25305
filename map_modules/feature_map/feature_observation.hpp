// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <vector>

#include "waymark/interface/map_module.hpp"

namespace waymark {

/// The discrete distribution that describes how a landmark looks (4.7): hue and saturation in an image, reflectivity in
/// two bins (dark, bright), an identity in one bin each. Without bins it is unknown: nothing has looked. Its storage
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
  /// What reading `identity` says about it: 1 − misreading_probability for its bin, the rest shared by the others. A
  /// negative identity, nothing read, is uniform.
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

/// One landmark as seen from the robot: position of its centre in the base frame and radius, (x, y, r), with one
/// covariance (4.1).
struct Detection {
  Eigen::Vector3d xyr = Eigen::Vector3d::Zero();  ///< [m]; r is meaningless where the map does not use it
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();    ///< noise covariance [m²]
  Signature signature;
  bool may_be_new = true;  ///< if it fits no landmark; false: nothing but the scan speaks for it
  int identity = -1;       ///< what a device read off it (a barcode, a tag); -1: nothing
  int first_beam = -1;     ///< of the scan, for pictures
  int last_beam = -1;
};

/// How a planar scan saw the surroundings: what a landmark that was not detected must be compared with.
struct ScanView {
  Eigen::Vector2d p_base_sensor = Eigen::Vector2d::Zero();
  double yaw_base_sensor = 0.0;
  double start = 0.0;  ///< bearing of beam 0 [rad]
  double step = 0.0;
  /// From one beam to the next the sensor moved so far [m], in its own frame, while the scan was taken. Its turn is in
  /// `step`, its way along each beam in the ranges: the rest shifts what is near by a little.
  Eigen::Vector2d way_per_beam = Eigen::Vector2d::Zero();
  /// Cleaned ranges: +inf where nothing came back (free), 0 where the beam tells nothing (the robot itself).
  std::vector<float> ranges;
};

/// What the feature map found in one measurement.
class FeatureObservation final : public Observation {
 public:
  Time stamp{};
  std::vector<Detection> detections;
  ScanView view;           ///< without ranges if the detections did not come from a scan
  double max_range = 0.0;  ///< farthest detection from the base [m]
};

}  // namespace waymark
