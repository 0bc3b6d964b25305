// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "column_map.hpp"
#include "waymark/interface/payload_field.hpp"

namespace waymark::csv {

/// The key of a field's column, one of `info.names`.
inline Config::Key key_of(const FieldInfo& info, std::string_view name) {
  return {name, info.unit, info.meaning, info.required ? "" : "optional"};
}

/// Throws BadRow if the value is beyond what the field allows.
void check_limit(Row row, const NumberColumn& column, const FieldInfo& info, double value);

/// Throws ConfigError if the column is a constant beyond what the field allows.
void check_constant(const Config& columns, const NumberColumn& column, const FieldInfo& info);

/// A quaternion out of its columns w, x, y, z. Nothing if all are unknown or zero. Throws BadRow if its norm is not 1.
std::optional<Eigen::Quaterniond> read_quaternion(Row row, const std::vector<NumberColumn>& wxyz,
                                                  const FieldInfo& info);

/// Columns for a vector of which all numbers are given or none. Throws ConfigError.
std::vector<NumberColumn> all_or_none(const Config& columns, const FieldInfo& info, std::string_view owner,
                                      ColumnFinder& finder);

/// A flag: the same word for all rows, or a column of 0 and 1.
class FlagColumn {
 public:
  /// Throws ConfigError.
  FlagColumn(const Config& columns, const FieldInfo& info, ColumnFinder& finder);
  /// Throws BadRow.
  bool read(Row row) const;

 private:
  bool always_ = false;
  std::optional<NumberColumn> column_;
};

/// A column of numbers, for each of which the YAML has a word; or the same word for all rows.
class WordColumn {
 public:
  /// `info.words` are the words. Throws ConfigError.
  WordColumn(const Config& columns, const FieldInfo& info, ColumnFinder& finder);
  /// The place of the row's word in `info.words`; nothing if the YAML has no word for its number. Throws BadRow.
  std::optional<int> read(Row row) const;

 private:
  std::optional<NumberColumn> column_;  // none: always the same
  std::optional<int> constant_;
  std::vector<std::pair<int, int>> words_;  // number in the file, place of its word
};

/// Reads the registered fields of a T (payload_field.hpp) out of the columns that the YAML gives them.
template <HasFields T>
class FieldColumns {
 public:
  /// Throws ConfigError for a column that T has no field for, and for a required field without a column; `owner` is
  /// what such messages call T. A required field `but` may be left out: the caller fills it.
  FieldColumns(const Config& columns, std::string_view owner, ColumnFinder& finder, std::string_view but = {})
      : but_(but) {
    check_names(columns, owner, but);
    // Numbers first, so that the first fault of a row is one of theirs.
    for (const bool numbers : {true, false}) {
      T::fields([&](auto member, const FieldInfo& info) {
        using Member = std::remove_cvref_t<decltype(std::declval<T&>().*member)>;
        constexpr bool kIsNumbers =
            std::is_same_v<Member, double> || !(std::is_integral_v<Member> || std::is_enum_v<Member>);
        if (kIsNumbers == numbers) add(columns, owner, member, info, finder);
      });
    }
  }

  /// Throws ConfigError as the constructor does, without looking for columns.
  static void check_names(const Config& columns, std::string_view owner, std::string_view but = {}) {
    std::vector<FieldName> valid;
    std::vector<std::string_view> required;
    T::fields([&](auto, const FieldInfo& info) {
      for (const std::string_view name : info.names) {
        if (name.empty()) continue;
        valid.push_back({name, info.unit});
        if (info.required && name != but) required.push_back(name);
      }
    });
    check_fields(columns, valid, required, owner);
  }

  /// Throws BadRow, and may have filled some fields then.
  void read(Row row, T& out) const {
    for (const Field& field : fields_) std::visit([&](const auto& one) { read(row, one, out); }, field);
  }

  /// True if the field of every required number is empty.
  bool required_are_empty(Row row) const {
    for (const Field& field : fields_) {
      const auto* number = std::get_if<Number>(&field);
      if (number != nullptr && number->info.required && !number->column.is_empty(row)) return false;
    }
    return true;
  }

  /// Per second, if `before` and `after` hold totals. Of a T that has numbers only.
  void growth(const T& before, const T& after, double seconds, double wraps_at, T& out) const {
    for (const Field& field : fields_) {
      const auto& [member, column, info] = std::get<Number>(field);
      out.*member = column.growth(before.*member, after.*member, wraps_at) / seconds;
    }
  }

 private:
  struct Number {
    double T::*member;
    NumberColumn column;
    FieldInfo info;
  };
  struct Vector {
    Eigen::Vector3d T::*member;
    std::vector<std::pair<Eigen::Index, NumberColumn>> axes;
  };
  struct Quaternion {
    Eigen::Quaterniond T::*member;
    std::vector<NumberColumn> wxyz;
    FieldInfo info;
  };
  struct Integer {
    int T::*member;
    NumberColumn column;
  };
  struct Flag {
    bool T::*member;
    FlagColumn column;
  };
  struct Word {
    WordColumn column;
    std::function<void(T& out, int number)> set;
  };
  using Field = std::variant<Number, Vector, Quaternion, Integer, Flag, Word>;

  std::optional<NumberColumn> column(const Config& columns, const FieldInfo& info, std::string_view name,
                                     ColumnFinder& finder) const {
    return info.required && name != but_ ? NumberColumn(columns, key_of(info, name), finder)
                                         : optional_number_column(columns, key_of(info, name), finder);
  }

  void add(const Config& columns, std::string_view, double T::*member, const FieldInfo& info, ColumnFinder& finder) {
    auto found = column(columns, info, info.name(), finder);
    if (!found) return;
    check_constant(columns, *found, info);
    fields_.push_back(Number{member, std::move(*found), info});
  }
  void add(const Config& columns, std::string_view owner, Eigen::Vector3d T::*member, const FieldInfo& info,
           ColumnFinder& finder) {
    Vector vector{member, {}};
    if (info.required || info.separable) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        if (auto found = column(columns, info, info.names[static_cast<std::size_t>(i)], finder))
          vector.axes.emplace_back(i, std::move(*found));
      }
    } else {
      for (NumberColumn& axis : all_or_none(columns, info, owner, finder))
        vector.axes.emplace_back(static_cast<Eigen::Index>(vector.axes.size()), std::move(axis));
    }
    fields_.push_back(std::move(vector));
  }
  void add(const Config& columns, std::string_view owner, Eigen::Quaterniond T::*member, const FieldInfo& info,
           ColumnFinder& finder) {
    const std::string meaning = std::string(info.meaning) + "; four zeros: unknown";
    FieldInfo described = info;
    described.meaning = meaning;
    auto wxyz = all_or_none(columns, described, owner, finder);
    if (!wxyz.empty()) fields_.push_back(Quaternion{member, std::move(wxyz), info});
  }
  void add(const Config& columns, std::string_view, int T::*member, const FieldInfo& info, ColumnFinder& finder) {
    if (auto found = column(columns, info, info.name(), finder)) fields_.push_back(Integer{member, std::move(*found)});
  }
  void add(const Config& columns, std::string_view, bool T::*member, const FieldInfo& info, ColumnFinder& finder) {
    if (columns.has(info.name())) fields_.push_back(Flag{member, FlagColumn(columns, info, finder)});
  }
  template <class Member>
  void add(const Config& columns, std::string_view, Member member, const FieldInfo& info, ColumnFinder& finder) {
    using Enum = std::remove_cvref_t<decltype(std::declval<T&>().*member)>;
    static_assert(std::is_enum_v<Enum>, "lists are not read from rows");
    if (!columns.has(info.name())) return;
    fields_.push_back(Word{WordColumn(columns, info, finder),
                           [member](T& out, int number) { out.*member = static_cast<Enum>(number); }});
  }

  void read(Row row, const Number& field, T& out) const {
    if (!field.info.required && field.column.is_unknown(row)) return;
    out.*field.member = field.column.read(row);
    check_limit(row, field.column, field.info, out.*field.member);
  }
  void read(Row row, const Vector& field, T& out) const {
    for (const auto& [axis, column] : field.axes) (out.*field.member)[axis] = column.read(row);
  }
  void read(Row row, const Quaternion& field, T& out) const {
    if (const auto q = read_quaternion(row, field.wxyz, field.info)) out.*field.member = *q;
  }
  void read(Row row, const Integer& field, T& out) const {
    if (!field.column.is_unknown(row)) out.*field.member = field.column.read_integer(row);
  }
  void read(Row row, const Flag& field, T& out) const { out.*field.member = field.column.read(row); }
  void read(Row row, const Word& field, T& out) const {
    if (const auto number = field.column.read(row)) field.set(out, *number);
  }

  std::string but_;
  std::vector<Field> fields_;
};

}  // namespace waymark::csv
