// SPDX-License-Identifier: Apache-2.0
#include "model_files.hpp"

#include <dlfcn.h>

#include <cstdlib>

namespace waymark::magnetic_model {

std::vector<std::filesystem::path> model_folders() {
  std::vector<std::filesystem::path> folders;
  if (const char* named = std::getenv("WAYMARK_MAGNETIC_MODEL"); named != nullptr && *named != '\0') {
    folders.emplace_back(named);
  }
  static const int here = 0;  // an address inside the library that this is linked into
  Dl_info info{};
  if (dladdr(&here, &info) != 0 && info.dli_fname != nullptr) {
    std::error_code none;
    const auto file = std::filesystem::weakly_canonical(info.dli_fname, none);
    // A plugin lies in lib/waymark/plugins, a program in bin.
    for (const char* up : {"../../..", ".."}) {
      folders.push_back((file.parent_path() / up / "share/waymark/magnetic").lexically_normal());
    }
  }
  return folders;
}

}  // namespace waymark::magnetic_model
