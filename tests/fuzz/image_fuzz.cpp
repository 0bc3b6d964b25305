// SPDX-License-Identifier: Apache-2.0
// Images of a log: JPEG, PNG, or rows of pixels.
#include "input.hpp"
#include "map_modules/feature_map/extraction/image_decoding.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  const fuzz::Choice choice = fuzz::choose(fuzz::text_of(data, size), 3);
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
    fuzz::violation("an image has another size than the intrinsics");
  return 0;
}
