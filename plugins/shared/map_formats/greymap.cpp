// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/greymap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <limits>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark::map_formats {

namespace {

// As many pixels are read at most, whatever the header claims: a map of 1.6 km × 1.6 km with cells of 5 cm.
constexpr std::int64_t kMostPixels = std::int64_t{1} << 30;

/// The next number of the header; comments run from # to the end of the line.
std::int64_t header_number(std::istream& in, const std::filesystem::path& file, const char* what) {
  int c = in.get();
  while (c == '#' || std::isspace(c) != 0) {
    if (c == '#') in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    c = in.get();
  }
  std::int64_t value = 0;
  int digits = 0;
  for (; std::isdigit(c) != 0 && digits < 10; ++digits, c = in.get()) value = 10 * value + (c - '0');
  if (digits == 0 || std::isspace(c) == 0) {
    throw DataError(fmt::format("{}: the header of a greymap has no {} where one was expected", file.string(), what));
  }
  return value;
}

}  // namespace

Greymap read_greymap(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw DataError(fmt::format("{}: not found, or not readable", file.string()));
  std::string magic(2, '\0');
  in.read(magic.data(), 2);
  if (magic != "P5") {
    std::ranges::replace_if(
        magic, [](char c) { return c < ' ' || c > '~'; }, '.');
    throw DataError(fmt::format("{}: not a binary greymap: it begins with \"{}\", P5 is expected", file.string(),
                                magic.substr(0, static_cast<std::size_t>(in.gcount()))));
  }
  const std::int64_t width = header_number(in, file, "width");
  const std::int64_t height = header_number(in, file, "height");
  const std::int64_t white = header_number(in, file, "largest value");
  if (width < 1 || height < 1 || width > kMostPixels / height) {
    throw DataError(
        fmt::format("{}: {} x {} pixels; a map has from 1 to {}", file.string(), width, height, kMostPixels));
  }
  if (white < 1 || white > 255) {
    throw DataError(fmt::format("{}: the largest value is {}; from 1 to 255 was expected", file.string(), white));
  }
  // Before memory is taken: is the file as long as its header claims?
  const auto begin = in.tellg();
  in.seekg(0, std::ios::end);
  const std::int64_t there = in.tellg() - begin;
  in.seekg(begin);
  if (there != width * height) {
    throw DataError(fmt::format("{}: {} x {} pixels are {} bytes, but {} are there", file.string(), width, height,
                                width * height, there));
  }
  Greymap map{static_cast<int>(width), static_cast<int>(height), static_cast<int>(white), {}};
  map.pixels.resize(static_cast<std::size_t>(there));
  in.read(reinterpret_cast<char*>(map.pixels.data()), there);
  if (!in) throw DataError(fmt::format("{}: reading failed", file.string()));
  return map;
}

}  // namespace waymark::map_formats
