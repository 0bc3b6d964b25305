// SPDX-License-Identifier: Apache-2.0
#include "image_builder.hpp"

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <system_error>
#include <utility>

#include "bad_row.hpp"
#include "number_text.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::csv {
namespace {

constexpr std::uintmax_t kLargestImage = std::uintmax_t{1} << 28;

}  // namespace

ImageBuilder::ImageBuilder(const Config& columns, std::filesystem::path folder, ColumnFinder& finder)
    : folder_(std::move(folder)) {
  check_fields(columns, {{"file", ""}}, {"file"}, "Image");
  file_ =
      finder.find(columns, {"file", "a JPEG or PNG, relative to the folder of the CSV; delivered as it is"}, "file");
}

std::shared_ptr<Payload> ImageBuilder::build(Row row) const {
  const std::string_view name = row[file_.index];
  if (name.empty()) throw BadRow(file_.label + " is empty, the name of an image file is expected");
  const std::filesystem::path path = folder_ / name;
  const auto refuse = [&](const std::string& why) {
    throw BadRow("image " + path.string() + " in " + file_.label + " " + why);
  };
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) refuse("cannot be read: " + error.message());
  if (size > kLargestImage) refuse("is larger than 256 MiB");
  auto image = std::make_shared<Image>();
  image->encoding = Image::Encoding::compressed;
  image->data.resize(size);
  errno = 0;
  std::basic_filebuf<char> file;
  if (file.open(path, std::ios::in | std::ios::binary) == nullptr)
    refuse("cannot be read: " + std::generic_category().message(errno));
  const auto wanted = static_cast<std::streamsize>(size);
  if (file.sgetn(reinterpret_cast<char*>(image->data.data()), wanted) != wanted) refuse("ends while it is read");
  return image;
}

}  // namespace waymark::csv
