// SPDX-License-Identifier: Apache-2.0
#include "image_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <utility>

#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::log_sink {
namespace {

std::string_view as_text(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// By what the file begins with: that is what readers go by, too.
const char* extension_of(std::string_view file) {
  if (file.starts_with("\x89PNG")) return "png";
  if (file.starts_with("\xff\xd8")) return "jpg";
  return "bin";
}

}  // namespace

ImageFiles::ImageFiles(std::filesystem::path folder, int png_compression)
    : folder_(std::move(folder)), png_compression_(png_compression) {}

std::string ImageFiles::add(const Image& image) {
  if (count_ == 0) create_folder(folder_);
  const bool compressed = image.encoding == Image::Encoding::compressed;
  const std::vector<std::uint8_t> pixels = compressed ? std::vector<std::uint8_t>() : encode(image);
  const std::string_view content = as_text(compressed ? image.data : pixels);
  const std::string name = fmt::format("{:06}.{}", count_, extension_of(content));
  write_file(folder_ / name, content);
  ++count_;
  return (folder_.filename() / name).string();
}

std::vector<std::uint8_t> ImageFiles::encode(const Image& image) const {
  const bool mono = image.encoding == Image::Encoding::mono8;
  const bool whole = image.width > 0 && image.height > 0 &&
                     image.data.size() == static_cast<std::size_t>(image.width) *
                                              static_cast<std::size_t>(image.height) * (mono ? 1 : 3);
  if (!whole) {
    throw Error(fmt::format("{}: image {}: {} bytes are not {} x {} pixels", folder_.string(), count_,
                            image.data.size(), image.width, image.height));
  }
  cv::Mat matrix(image.height, image.width, mono ? CV_8UC1 : CV_8UC3);  // OpenCV has no view of constant bytes
  std::copy(image.data.begin(), image.data.end(), matrix.data);
  std::vector<std::uint8_t> file;
  if (!cv::imencode(".png", matrix, file, {cv::IMWRITE_PNG_COMPRESSION, png_compression_}))
    throw Error(fmt::format("{}: image {}: cannot be written as PNG", folder_.string(), count_));
  return file;
}

}  // namespace waymark::log_sink
