// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

namespace waymark::command {

/// A file of a new plugin's project. In name and text, @name@ is the plugin's name and @Name@ the start of its
/// classes'.
struct TemplateFile {
  std::string_view kind;  ///< "sensor", "map-module", "source", "sink"
  std::string_view name;
  std::string_view text;
};

/// The files of all kinds, made of apps/waymark/command/new_plugin when waymark is built.
std::span<const TemplateFile> plugin_templates();

}  // namespace waymark::command
