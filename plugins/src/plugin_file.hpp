// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "waymark/plugin/descriptor.hpp"

namespace waymark {

/// Reads a library's record from its file, without mapping or loading it: nothing of the library runs,
/// and a file that is cut short is found by its headers. A plugin of before ABI 10 has none: only `abi` is read, from
/// its symbol. Throws PluginError, whose text starts with the file, if the
/// file is missing, is not a whole library for this machine, or holds no record.
PluginRecord read_plugin_record(const std::filesystem::path& file);

/// The ABI that the exported symbol `waymark_plugin` begins with, read as above; nothing if there is no such symbol.
/// Throws as above.
std::optional<std::uint32_t> read_symbol_abi(const std::filesystem::path& file);

/// Why a library with this record does not fit this program (another ABI, build key or Eigen alignment, or no complete
/// record), or an empty text.
std::string misfit(const PluginRecord& record);

/// A text of a record, up to its first zero.
template <std::size_t N>
std::string_view record_text(const char (&field)[N]) {
  const std::string_view whole(field, N);
  return whole.substr(0, whole.find('\0'));
}

/// The name of the plugin that a file is expected to hold: `gps` for `waymark_gps.so`; empty if the file is not called
/// so.
std::string plugin_name_of(const std::filesystem::path& file);

/// "is a dangling link to ...", or an empty text if the file is there or is not a link.
std::string dangling_link(const std::filesystem::path& file);

/// The refusal of a library that has no `waymark_plugin`.
PluginError not_a_plugin();

}  // namespace waymark
