// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "waymark/plugin/descriptor.hpp"

namespace waymark {

/// An opened shared library that exports `waymark_plugin`.
struct PluginLibrary {
  std::shared_ptr<const void> handle;  ///< keeps the library loaded
  const PluginDescriptor* descriptor;  ///< within the library, never null
};

/// Opens a file once per process and keeps it for ever; a second call for the same file, under whatever path, gives the
/// same library. Safe to call from many threads. Throws PluginError, whose text starts with the file, if the file is
/// missing, is not a library that this program can load, or exports no descriptor.
PluginLibrary open_plugin_library(const std::filesystem::path& file);

/// Why the library does not fit this program (another ABI, build key or Eigen alignment), or an empty text. Calls no
/// code of the library.
std::string misfit(const PluginDescriptor& descriptor);

/// The name of the plugin that a file is expected to hold: `gps` for `waymark_gps.so`; empty if the file is not called
/// so.
std::string plugin_name_of(const std::filesystem::path& file);

}  // namespace waymark
