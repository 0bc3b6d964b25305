// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/types.hpp>

namespace waymark::feature_map {

// What the pictures of the extraction have in common; (blue, green, red).
inline const cv::Scalar kInk(60, 52, 45);
inline const cv::Scalar kGrid(228, 224, 220);

}  // namespace waymark::feature_map
