// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "waymark/plugin_loader.hpp"

namespace waymark {

/// A plugin's descriptor as its file holds it, beside what PluginInfo has. Of another ABI only `abi` is known: the rest
/// may have another layout.
struct PluginInspection : PluginInfo {
  std::uint32_t abi = 0;
  std::uint32_t eigen_max_align = 0;  ///< [bytes]
  std::string build_key;
};

/// What a plugin's file says about itself, and why the loader would refuse it (`problem`). Nothing of the library runs,
/// so functions and libraries that it needs and that are missing are not found here, but when it is loaded. Throws
/// PluginError, whose text starts with the file, if the file is missing, is no whole library for this machine, or no
/// plugin.
PluginInspection inspect_plugin(const std::filesystem::path& file);

}  // namespace waymark
