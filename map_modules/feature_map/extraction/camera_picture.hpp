// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "map_modules/feature_map/extraction/camera_extraction.hpp"

namespace waymark::feature_map {

/// An image with the scan's returns on it, as a PNG file (after Fig. 4.2 of the paper): the region of every candidate,
/// green with its number where a pair of edges was found, red where it was expected and not found; to the right the
/// hue–saturation histogram of each region, in its bins' own colours. `look` must hold pixels. Throws Error if it
/// cannot be encoded.
std::string draw_look(const ScanView& view, const Pose& T_base_scanner, const std::vector<Candidate>& candidates,
                      const ImageLook& look, const CameraSettings& settings, const std::string& title);

}  // namespace waymark::feature_map
