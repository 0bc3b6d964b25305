// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/signature.hpp"

namespace waymark::feature_map {

/// Normalised histogram of hue and saturation over a region of 8-bit BGR pixels (§4.1; P. Pérez, C. Hue, J. Vermaak,
/// M. Gangnet, ECCV 2002): bin = hue bin · saturation bins + saturation bin. A
/// pixel votes for the bins whose middles it lies between, linearly: with hard borders a little change of the light
/// moves all of a plain colour into the next bin. The first hue bin has pure red in its middle, where hue begins and
/// ends. Pixels darker than `value_min` have no
/// colour and are left out; with too few others, the signature is unknown.
Signature hue_saturation(const cv::Mat& bgr, const CameraSettings& settings);

}  // namespace waymark::feature_map
