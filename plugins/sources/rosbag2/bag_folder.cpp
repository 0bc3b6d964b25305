// SPDX-License-Identifier: Apache-2.0
#include "bag_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>

#include "waymark/base/error.hpp"
#include "waymark/config/config.hpp"

namespace waymark::rosbag2 {
namespace {

namespace fs = std::filesystem;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_part(const fs::path& file) {
  constexpr std::array<std::string_view, 3> kPacked{".gz", ".zst", ".zstd"};
  fs::path name = file.filename();
  if (std::ranges::find(kPacked, name.extension().string()) != kPacked.end()) name = name.stem();
  return name.extension() == ".db3" || name.extension() == ".mcap";
}

/// The digits at the end of a part's name count as a number: _10 comes behind _9.
bool comes_before(const fs::path& a, const fs::path& b) {
  const std::string x = a.filename().string();
  const std::string y = b.filename().string();
  return x.size() != y.size() ? x.size() < y.size() : x < y;
}

std::vector<fs::path> parts_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && is_part(entry.path())) files.push_back(entry.path());
  }
  std::ranges::sort(files, comes_before);
  return files;
}

/// Where a part of the metadata lies: old bags have the folder's name in front, and some lack the compression's ending.
fs::path locate(const fs::path& folder, const std::string& name, const std::string& compression) {
  const fs::path file = fs::path(name).filename();
  for (const fs::path& candidate : {folder / file, folder / (file.string() + "." + compression)}) {
    if (fs::is_regular_file(candidate)) return candidate;
  }
  throw DataError(fmt::format("{}: names the part {}, which is not there", (folder / "metadata.yaml").string(), name));
}

BagParts read_metadata(const fs::path& folder) {
  const fs::path file = folder / "metadata.yaml";
  BagParts parts;
  try {
    // As configurations, since a hostile one is as well bounded.
    const Config bag = Config::load(file).child("rosbag2_bagfile_information");
    const auto word = [&](const char* key) { return bag.has(key) ? lower(bag.text(key)) : std::string(); };
    const std::string format = word("compression_format");
    if (!format.empty() && format != "zstd")
      bag.fail("compression_format", fmt::format("the compression \"{}\" is not known; zstd is", format));
    parts.compressed_messages = word("compression_mode") == "message";
    for (const std::string& part : bag.texts("relative_file_paths"))
      parts.files.push_back(locate(folder, part, format));
  } catch (const ConfigError& error) {
    throw DataError(error.what());
  }
  return parts;
}

}  // namespace

BagParts find_parts(const fs::path& bag) {
  if (!fs::is_directory(bag)) return {{bag}, false};
  BagParts parts = fs::exists(bag / "metadata.yaml") ? read_metadata(bag) : BagParts{parts_in(bag), false};
  if (parts.files.empty()) throw DataError(bag.string() + ": has no parts (.db3 or .mcap)");
  return parts;
}

}  // namespace waymark::rosbag2
