// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "waymark/plugin_loader.hpp"

namespace waymark {

std::vector<std::filesystem::path> PluginLoader::standard_search_path(std::vector<std::filesystem::path> first) {
  std::vector<std::filesystem::path> folders = std::move(first);
  if (const char* variable = std::getenv("WAYMARK_PLUGIN_PATH"); variable != nullptr) {
    std::string_view rest = variable;
    while (!rest.empty()) {
      const auto colon = rest.find(':');
      const auto folder = rest.substr(0, colon);
      // An empty element would mean the working folder: a surprise, and a risk.
      if (!folder.empty()) folders.emplace_back(folder);
      rest = colon == std::string_view::npos ? std::string_view{} : rest.substr(colon + 1);
    }
  }
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(program.parent_path().parent_path() / "lib" / "waymark" / "plugins");
  return folders;
}

}  // namespace waymark
