// SPDX-License-Identifier: Apache-2.0
// Errors of commands on maps, which name the file.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <new>

#include "waymark/base/error.hpp"

namespace waymark::command {

/// Runs a command on `file`; a map that does not fit into memory is an Error.
template <class Command>
auto run_on(const std::filesystem::path& file, const Command& command) {
  try {
    return command();
  } catch (const std::bad_alloc&) {
    throw Error(fmt::format("{}: the map needs more memory than there is", file.string()));
  }
}

/// Runs `what`; what it throws about the content of a file names the file.
template <class What>
auto about(const std::filesystem::path& file, const What& what) {
  try {
    return what();
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", file.string(), error.what()));
  }
}

}  // namespace waymark::command
