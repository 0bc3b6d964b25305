// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/sweep/study.hpp"

namespace waymark::sweep {

/// A score of a variant over its seeds.
struct Cell {
  std::vector<double> values;  ///< in the order of the seeds, without those that have none
  double min = 0.0;
  double median = 0.0;
  double max = 0.0;
  /// Whether the score reaches its mark; nothing if it has none, or no value.
  std::optional<bool> reached;
  double mean = 0.0;
  bool shows_mean = false;  ///< the mean alone, instead of min / median / max
};

/// A variant in the table.
struct Line {
  std::string name;
  std::size_t ended = 0;  ///< seeds with a result
  std::vector<Cell> cells;
};

/// A failed task, for a list.
struct Failure {
  Task task;
  std::string variant;
  std::string error;
};

/// The results of a study so far.
struct Summary {
  std::vector<Line> lines;
  std::vector<Failure> failures;
  std::size_t tasks = 0;
  std::size_t ended = 0;  ///< with a result, failures not included
};

Summary summarize(const Study& study);

}  // namespace waymark::sweep
