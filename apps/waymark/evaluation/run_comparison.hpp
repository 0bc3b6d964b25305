// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/waymark/evaluation/report.hpp"

namespace waymark::evaluation {

/// The report of a run, under the name of its folder.
struct NamedReport {
  std::string name;
  Report report;
};

/// The runs as rows of one table; a quantity that no run has is left out, "-": this run has none. The position error is
/// that in the plane if all estimates are planar. Ends with a newline.
std::string to_table(const std::vector<NamedReport>& reports);

/// A JSON object on one line with a list `runs`; each is as `to_json` of its report, with its name as `run`.
std::string to_json(const std::vector<NamedReport>& reports);

}  // namespace waymark::evaluation
