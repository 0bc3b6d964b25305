// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "waymark/plugin/descriptor.hpp"

namespace waymark {

/// An opened shared library that exports `waymark_plugin`.
struct PluginLibrary {
  std::shared_ptr<const void> handle;  ///< keeps the library loaded
  const PluginDescriptor* descriptor;  ///< within the library, never null, with `create`
};

/// Opens a file once per process and keeps it for ever; a second call for the same file, under whatever path, gives the
/// same library. The library's static initialisers run, so `record`, as read from the file, must fit this program. Safe
/// to call from many threads. Throws PluginError, whose text starts with the file, if the file is missing, is not a
/// library that this program can load, or exports no descriptor with the contents of `record`.
PluginLibrary open_plugin_library(const std::filesystem::path& file, const PluginRecord& record);

}  // namespace waymark
