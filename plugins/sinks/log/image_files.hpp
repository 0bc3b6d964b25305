// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "waymark/interface/payloads.hpp"

namespace waymark::log_sink {

/// The images of one sensor as files in a folder of their own, 000000.png and so on.
class ImageFiles {
 public:
  /// The folder is made with the first image. `png_compression`: 0 (fast) to 9 (small).
  ImageFiles(std::filesystem::path folder, int png_compression);

  /// Writes one image, pixels as PNG and a compressed image as it is. Returns its path, relative to where the folder
  /// lies. Throws Error.
  std::string add(const Image& image);

 private:
  /// The file's bytes for pixels.
  std::vector<std::uint8_t> encode(const Image& image) const;

  std::filesystem::path folder_;
  int png_compression_;
  std::uint64_t count_ = 0;
};

}  // namespace waymark::log_sink
