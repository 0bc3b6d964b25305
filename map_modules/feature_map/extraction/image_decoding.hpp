// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/rig.hpp"

namespace waymark::feature_map {

/// What an image was good for.
enum class ImageState {
  used,
  missing,      ///< there was none, or none that is fresh enough
  undecodable,  ///< neither a PNG nor a JPEG, or one that OpenCV cannot read
  wrong_size,   ///< not the size that the intrinsics are for, or other than as many bytes as that takes
  dark,         ///< nearly all black: night, or a covered lens
  overexposed   ///< nearly all white
};
inline constexpr std::size_t kImageStates = 6;

struct DecodedImage {
  ImageState state = ImageState::missing;
  cv::Mat bgr;  ///< 8 bits per channel, its own copy; empty if missing, undecodable or of the wrong size
};

/// The pixels of an image that fits the intrinsics. Does not throw for what a camera or a log can do wrong.
DecodedImage decode(const Image& image, const Intrinsics& intrinsics);

}  // namespace waymark::feature_map
