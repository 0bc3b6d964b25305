// SPDX-License-Identifier: Apache-2.0
#include "registered_builder.hpp"

#include <algorithm>
#include <memory>
#include <span>

#include "waymark/interface/payload_edit.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::csv {
namespace {

/// Counts the elements of a payload's list.
class ListSize final : public FieldVisitor {
 public:
  void field(const FieldInfo&, const FieldValue&) override {}
  void list(const FieldInfo&, std::size_t size) override { size_ = size; }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

/// Gives a list one element, and hands over each field.
template <class Use>
class EachField final : public FieldEditor {
 public:
  explicit EachField(Use use) : use_(std::move(use)) {}
  void field(const FieldInfo& info, const FieldSlot& slot) override { use_(info, slot); }
  std::size_t list(const FieldInfo&) override { return 1; }

 private:
  Use use_;
};

/// Throws ConfigError for a column that the payload has no field for, and for a required field without a column.
void check_names(Payload& payload, const Config& columns, std::string_view owner) {
  std::vector<FieldName> valid;
  std::vector<std::string_view> required;
  EachField each([&](const FieldInfo& info, const FieldSlot&) {
    for (const std::string_view name : info.names) {
      if (name.empty()) continue;
      valid.push_back({name, info.unit});
      if (info.required) required.push_back(name);
    }
  });
  payload.edit(each);
  check_fields(columns, valid, required, owner);
}

}  // namespace

/// Finds the columns of all fields.
class RegisteredBuilder::Planner final : public FieldEditor {
 public:
  Planner(RegisteredBuilder& builder, const Config& columns, ColumnFinder& finder)
      : builder_(builder), columns_(columns), finder_(finder), owner_(short_type_name(builder.type_)) {}

  void field(const FieldInfo& info, const FieldSlot& slot) override {
    (builder_.has_list_ ? builder_.of_elements_ : builder_.fields_).push_back(plan(info, slot));
  }
  std::size_t list(const FieldInfo& info) override {
    if (builder_.has_list_) fail(info);
    builder_.has_list_ = true;
    return 1;
  }

 private:
  [[noreturn]] void fail(const FieldInfo& info) const {
    columns_.fail(std::string(owner_) + " has " + in_quotes(info.name()) + ", which a row cannot hold");
  }

  Field plan(const FieldInfo& info, const FieldSlot& slot) {
    if (const auto* numbers = std::get_if<std::span<double>>(&slot)) {
      if (numbers->size() == 4) {
        auto wxyz = all_or_none(columns_, info, owner_, finder_);
        if (wxyz.empty()) return NotGiven{};
        return Quaternion{info, std::move(wxyz)};
      }
      return plan_numbers(info, numbers->size());
    }
    if (std::holds_alternative<int*>(slot)) {
      auto column = find(info, info.name());
      if (!column) return NotGiven{};
      return Integer{std::move(*column)};
    }
    const bool is_flag = std::holds_alternative<bool*>(slot);
    if (!is_flag && !std::holds_alternative<WordSlot>(slot)) {
      if (info.required) fail(info);
      return NotGiven{};
    }
    if (!columns_.has(info.name())) return NotGiven{};
    if (is_flag) return FlagColumn(columns_, info, finder_);
    return WordColumn(columns_, info, finder_);
  }

  Field plan_numbers(const FieldInfo& info, std::size_t count) {
    Numbers found{info, {}};
    if (count > 1 && !info.required && !info.separable) {
      for (NumberColumn& column : all_or_none(columns_, info, owner_, finder_))
        found.columns.emplace_back(found.columns.size(), std::move(column));
      return found;
    }
    for (std::size_t i = 0; i < count; ++i) {
      auto column = find(info, info.names.at(i));
      if (!column) continue;
      check_constant(columns_, *column, info);
      found.columns.emplace_back(i, std::move(*column));
    }
    return found;
  }

  std::optional<NumberColumn> find(const FieldInfo& info, std::string_view name) const {
    return info.required ? NumberColumn(columns_, key_of(info, name), finder_)
                         : optional_number_column(columns_, key_of(info, name), finder_);
  }

  RegisteredBuilder& builder_;
  const Config& columns_;
  ColumnFinder& finder_;
  std::string_view owner_;
};

/// Sets the fields of a payload from a row: those of the last of its elements, and those beside the list if that is the
/// first one.
class RegisteredBuilder::Reader final : public FieldEditor {
 public:
  Reader(const RegisteredBuilder& builder, Row row, std::size_t elements)
      : builder_(builder), row_(row), elements_(elements), is_reading_(elements <= 1) {}

  void field(const FieldInfo&, const FieldSlot& slot) override {
    const Field& field = fields_->at(next_++);
    if (is_reading_) std::visit([&](const auto& one) { read(one, slot); }, field);
  }
  std::size_t list(const FieldInfo&) override {
    fields_ = &builder_.of_elements_;
    return elements_;
  }
  void element(std::size_t index) override {
    next_ = 0;
    is_reading_ = index + 1 == elements_;
  }

 private:
  void read(const NotGiven&, const FieldSlot&) const {}
  void read(const Numbers& field, const FieldSlot& slot) const {
    const auto numbers = std::get<std::span<double>>(slot);
    for (const auto& [place, column] : field.columns) {
      if (!field.info.required && column.is_unknown(row_)) continue;
      numbers[place] = column.read(row_);
      check_limit(row_, column, field.info, numbers[place]);
    }
  }
  void read(const Quaternion& field, const FieldSlot& slot) const {
    const auto q = read_quaternion(row_, field.wxyz, field.info);
    if (!q) return;
    const auto numbers = std::get<std::span<double>>(slot);
    numbers[0] = q->w();
    numbers[1] = q->x();
    numbers[2] = q->y();
    numbers[3] = q->z();
  }
  void read(const Integer& field, const FieldSlot& slot) const {
    if (!field.column.is_unknown(row_)) *std::get<int*>(slot) = field.column.read_integer(row_);
  }
  void read(const FlagColumn& field, const FieldSlot& slot) const { *std::get<bool*>(slot) = field.read(row_); }
  void read(const WordColumn& field, const FieldSlot& slot) const {
    const auto& word = std::get<WordSlot>(slot);
    if (const auto number = field.read(row_)) word.assign(word.value, *number);
  }

  const RegisteredBuilder& builder_;
  Row row_;
  std::size_t elements_;
  bool is_reading_;
  const std::vector<Field>* fields_ = &builder_.fields_;
  std::size_t next_ = 0;
};

RegisteredBuilder::RegisteredBuilder(std::string_view type, const Config& columns, ColumnFinder& finder)
    : type_(type), sets_may_be_empty_(finder.allows_empty()) {
  const auto payload = make_payload(type_);
  check_names(*payload, columns, short_type_name(type_));
  Planner planner(*this, columns, finder);
  payload->edit(planner);
}

std::shared_ptr<Payload> RegisteredBuilder::build(Row row) const {
  auto payload = make_payload(type_);
  Reader reader(*this, row, is_empty(row) ? 0 : 1);
  payload->edit(reader);
  return payload;
}

void RegisteredBuilder::append(Row row, Payload& payload) const {
  if (is_empty(row)) return;
  ListSize before;
  payload.visit(before);
  Reader reader(*this, row, before.size() + 1);
  payload.edit(reader);
}

/// A row that stands for a set without elements.
bool RegisteredBuilder::is_empty(Row row) const {
  if (!sets_may_be_empty_ || !has_list_) return false;
  return std::ranges::none_of(of_elements_, [&](const Field& field) {
    const auto* numbers = std::get_if<Numbers>(&field);
    return numbers != nullptr && numbers->info.required &&
           std::ranges::any_of(numbers->columns, [&](const auto& one) { return !one.second.is_empty(row); });
  });
}

}  // namespace waymark::csv
