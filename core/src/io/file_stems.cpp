// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/file_stems.hpp"

#include <algorithm>
#include <filesystem>

namespace waymark {

FileStems FileStems::of_results() {
  const auto stem = [](std::string_view file) { return std::filesystem::path(file).stem().string(); };
  return FileStems({stem(kEffectiveConfigFile), stem(kMapManifestFile)});
}

std::string FileStems::of(const std::string& name) {
  std::string stem = name;
  const auto is_foreign = [](char c) {
    return !((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-');
  };
  std::ranges::replace_if(stem, is_foreign, '_');
  std::string free = stem;
  for (int number = 2; !taken_.insert(free).second; ++number) free = stem + '_' + std::to_string(number);
  return free;
}

}  // namespace waymark
