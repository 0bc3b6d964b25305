// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "column_map.hpp"

namespace waymark::csv {

/// Keeps the rows that satisfy all conditions of the list `where`, such as those of one type of record.
class RowFilter {
 public:
  /// Throws ConfigError.
  RowFilter(const Config& config, const ColumnFinder& finder);

  /// Conditions are tried in their order, up to the first that a row does not satisfy. Throws BadRow if a row has not
  /// as many fields as that takes, or if a number is expected and is not there.
  bool keeps(Row row) const;
  /// Equal for equal conditions.
  const std::string& signature() const { return signature_; }

 private:
  /// What a field is compared with: numbers, or texts if one of them is no number.
  struct Values {
    std::vector<double> numbers;
    std::vector<std::string> words;

    bool hold(std::string_view field, double number) const;
  };
  struct Condition {
    Column column;
    std::optional<Values> in;
    Values not_in;
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool needs_number = true;

    bool keeps(std::string_view field) const;
  };

  static Values read_values(const std::vector<std::string>& words);
  static Condition read_condition(const Config& item, ColumnFinder& finder);

  std::vector<Condition> conditions_;
  std::string signature_;
};

}  // namespace waymark::csv
