// SPDX-License-Identifier: Apache-2.0
// Names of files that plugins write: within the output folder, and each only once.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "config/node.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/io/written_files.hpp"

namespace waymark {
namespace {

bool has_control_characters(std::string_view name) {
  return std::ranges::any_of(name, [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

bool leads_outside(const std::filesystem::path& normal) {
  return normal.empty() || normal == "." || normal.is_absolute() || *normal.begin() == "..";
}

/// Equal, or one is a folder in which the other lies.
bool overlap(const std::string& a, const std::string& b) {
  return a == b || a.starts_with(b + '/') || b.starts_with(a + '/');
}

}  // namespace

std::string Config::output(const Key& key, std::string_view fallback) const {
  std::string name = text(key, fallback);
  const std::filesystem::path normal = std::filesystem::path(name).lexically_normal();
  if (leads_outside(normal) && !root_->permits_outside) {
    fail(key.name, fmt::format("\"{}\" is not a name within the output folder (--allow-outside permits others)", name));
  }
  const std::string file = normal.string();
  if (has_control_characters(file)) fail(key.name, "a file's name has no control characters");
  if (file.ends_with(kPartialSuffix))
    fail(key.name,
         fmt::format("\"{}\": names that end in {} are of files that are not complete", name, kPartialSuffix));
  const std::array<std::string_view, 3> own{kEffectiveConfigFile, kWrittenFilesList, kOpenWrittenFilesList};
  if (std::ranges::any_of(own, [&](std::string_view one) { return overlap(file, std::string(one)); }))
    fail(key.name, fmt::format("\"{}\" is written by the run itself", name));
  const auto is_this = [&](const Node::Output& other) { return other.node == node_ && other.key == key.name; };
  for (const Node::Output& other : root_->outputs) {
    if (is_this(other) || !overlap(file, other.file)) continue;
    const std::string path = other.node->path();
    fail(key.name, fmt::format("\"{}\" is also written by {}{}{}", name, path, path.empty() ? "" : ".", other.key));
  }
  if (std::ranges::none_of(root_->outputs, is_this)) root_->outputs.push_back({file, node_, std::string(key.name)});
  return name;
}

void Config::permit_outside() const { root_->permits_outside = true; }

}  // namespace waymark
