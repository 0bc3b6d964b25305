// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "apps/waymark/sweep/summary.hpp"

namespace waymark::sweep {

/// The study as Markdown: title, table with min / median / max over the seeds, marks, failed tasks, command and
/// version.
std::string to_markdown(const Study& study, const Summary& summary, const std::string& command);

/// A page that a person wrote, with command, table and marks of the study between its lines "<!-- study: NAME -->" and
/// "<!-- end of study -->"; NAME is that of the plan's file without extension. Nothing if the page has no such lines.
std::optional<std::string> inserted(const std::string& page, const Study& study, const Summary& summary,
                                    const std::string& command);

/// The study as one HTML file, with a picture of every score: a dot for each seed.
std::string to_html(const Study& study, const Summary& summary, const std::string& command);

/// The table for a terminal.
std::string to_text(const Study& study, const Summary& summary);

/// All values as JSON, for `--check` and other programs.
std::string to_json(const Study& study, const std::string& command);

}  // namespace waymark::sweep
