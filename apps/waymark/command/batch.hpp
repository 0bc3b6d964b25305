// SPDX-License-Identifier: Apache-2.0
// What commands that do many courses or runs, and write a page about them, have in common.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace waymark::command {

/// Progress on standard error, "3 of 10 runs": on a terminal one line that is rewritten, elsewhere a line every tenth.
void report_ended(std::size_t ended, std::size_t count, std::string_view what);

/// Throws Error, before anything runs, if a page would be overwritten that a person wrote: one without the line that
/// the command, "waymark paper", begins its pages with. `option`: how to choose another.
void require_replaceable(const std::filesystem::path& page, std::string_view command, std::string_view option);

}  // namespace waymark::command
