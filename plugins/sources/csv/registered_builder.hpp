// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "field_columns.hpp"
#include "payload_builders.hpp"

namespace waymark::csv {

/// Payloads that a plugin registers (payload_registry.hpp). A row holds all fields; of a payload with a list, one
/// element of it, and the fields beside the list if it is the first row of a set.
class RegisteredBuilder final : public PayloadBuilder {
 public:
  /// Throws ConfigError, also for a payload with a field that no row can hold.
  RegisteredBuilder(std::string_view type, const Config& columns, ColumnFinder& finder);

  std::shared_ptr<Payload> build(Row row) const override;
  void append(Row row, Payload& payload) const override;
  bool can_append() const override { return has_list_; }

 private:
  struct Numbers {
    FieldInfo info;
    std::vector<std::pair<std::size_t, NumberColumn>> columns;  ///< with the place within a vector
  };
  struct Quaternion {
    FieldInfo info;
    std::vector<NumberColumn> wxyz;
  };
  struct Integer {
    NumberColumn column;
  };
  struct NotGiven {};
  /// What the YAML gives for one registered field.
  using Field = std::variant<NotGiven, Numbers, Quaternion, Integer, FlagColumn, WordColumn>;

  class Planner;
  class Reader;

  bool is_empty(Row row) const;

  std::string type_;
  bool sets_may_be_empty_;
  bool has_list_ = false;
  std::vector<Field> fields_;       // in the order in which they are registered, up to the list
  std::vector<Field> of_elements_;  // of the list's elements
};

}  // namespace waymark::csv
