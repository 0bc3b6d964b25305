// SPDX-License-Identifier: Apache-2.0
// Images of a log: JPEG, PNG, or rows of pixels.
#include "map_modules/feature_map/extraction/image_decoding.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::image_harness {
namespace {
void run(std::string_view input) {
  const Choice choice = choose(input, 3);
  const Intrinsics intrinsics{16, 12, 10.0, 10.0, 8.0, 6.0, {}};
  Image image;
  image.width = 16;
  image.height = 12;
  image.encoding = choice.which == 0   ? Image::Encoding::compressed
                   : choice.which == 1 ? Image::Encoding::mono8
                                       : Image::Encoding::bgr8;
  image.data.assign(choice.rest.begin(), choice.rest.end());
  const feature_map::DecodedImage decoded = feature_map::decode(image, intrinsics);
  if (!decoded.bgr.empty() && (decoded.bgr.cols != intrinsics.width || decoded.bgr.rows != intrinsics.height))
    violation("an image has another size than the intrinsics");
}

const Harness kHarness("image", run);

}  // namespace
}  // namespace waymark::fuzz::image_harness
