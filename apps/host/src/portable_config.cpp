// SPDX-License-Identifier: Apache-2.0
#include "portable_config.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

namespace waymark::host {

namespace {

/// A text as YAML, in double quotes.
std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\\') result += '\\';
    if (text.substr(i, 2) == "${") result += '$';  // or it would be taken for a variable
    if (static_cast<unsigned char>(c) < 0x20) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + '"';
}

}  // namespace

std::string portable_config(const Config& yaml) {
  const std::string folder = std::filesystem::absolute(yaml.file()).lexically_normal().parent_path().string();
  if (yaml.has("base_folder"))
    return Config::parse(yaml.effective(), "", {"base_folder=" + in_quotes(folder)}).effective();
  return fmt::format("{}base_folder: {}\n", yaml.effective(), in_quotes(folder));
}

}  // namespace waymark::host
