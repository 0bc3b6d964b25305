// SPDX-License-Identifier: Apache-2.0
#include "payload_columns.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <variant>

#include "waymark/base/error.hpp"
#include "waymark/base/overloaded.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/interface/payload_registry.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

using Kind = FieldSpec::Kind;

/// Notes the fields of a payload. Each list gets two elements: where the second one begins, the first one ends.
class SpecEditor final : public FieldEditor {
 public:
  std::vector<FieldSpec> specs;

  void field(const FieldInfo& info, const FieldSlot& slot) override {
    if (known_ > 0) {
      --known_;
      return;
    }
    const Kind kind =
        std::visit(Overloaded{[](const std::span<double>&) { return Kind::number; }, [](int*) { return Kind::integer; },
                              [](bool*) { return Kind::flag; }, [](const WordSlot&) { return Kind::word; },
                              [](std::vector<float>*) { return Kind::numbers; },
                              [](std::vector<Eigen::Vector3f>*) { return Kind::points; },
                              [](std::vector<std::uint8_t>*) { return Kind::bytes; }},
                   slot);
    specs.push_back({info, kind, 0});
  }
  std::size_t list(const FieldInfo& info) override {
    list_ = specs.size();
    specs.push_back({info, Kind::list, 0});
    return 2;
  }
  void element(std::size_t index) override {
    if (index == 0) return;
    known_ = specs.size() - list_ - 1;
    specs[list_].elements = known_;
  }

 private:
  std::size_t list_ = 0;
  std::size_t known_ = 0;  // fields of a second element that are still to come
};

bool is_list(Kind kind) { return kind == Kind::numbers || kind == Kind::points || kind == Kind::bytes; }

std::vector<std::string> names_of(const std::vector<FieldSpec>& specs) {
  std::vector<std::string> names;
  for (const FieldSpec& spec : specs) {
    if (spec.kind == Kind::list) continue;
    for (const std::string_view name : spec.info.names) {
      if (!name.empty()) names.emplace_back(name);
    }
  }
  return names;
}

std::vector<std::string_view> payload_types() {
  std::vector<std::string_view> types;
  for (const KnownPayload& payload : known_payloads()) types.push_back(payload.type);
  return types;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += ", ";
    text += word;
  }
  return text;
}

/// Names of the required fields that are not among the columns.
std::vector<std::string> missing_in(const std::vector<FieldSpec>& specs, const py::dict& columns) {
  std::vector<std::string> missing;
  for (const FieldSpec& spec : specs) {
    if (spec.kind == Kind::list || !spec.info.required) continue;
    for (const std::string_view name : spec.info.names) {
      if (!name.empty() && !columns.contains(py::str(name.data(), name.size()))) missing.emplace_back(name);
    }
  }
  return missing;
}

/// The payloads that have all fields of `columns`, and whose required ones are all among them.
std::vector<std::string> types_with(const py::dict& columns) {
  std::vector<std::string> found;
  for (const std::string_view type : payload_types()) {
    const std::vector<FieldSpec> specs = fields_of(*make_payload(type));
    const std::vector<std::string> names = names_of(specs);
    const bool has_all = std::ranges::all_of(columns, [&](const auto& item) {
      return std::ranges::find(names, py::cast<std::string>(item.first)) != names.end();
    });
    if (has_all && missing_in(specs, columns).empty()) found.emplace_back(type);
  }
  return found;
}

std::vector<std::string> column_names(const py::dict& columns) {
  std::vector<std::string> names;
  for (const auto& item : columns) names.push_back(py::cast<std::string>(item.first));
  return names;
}

template <class T>
py::array_t<T, py::array::c_style | py::array::forcecast> array_of(const py::handle& value) {
  auto array = py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(value);
  if (!array) {
    PyErr_Clear();
    throw DataError("expected numbers");
  }
  return array;
}

}  // namespace

std::vector<FieldSpec> fields_of(Payload& payload) {
  SpecEditor editor;
  payload.edit(editor);
  return std::move(editor.specs);
}

/// Sets the fields of one measurement.
class PayloadColumns::RowEditor final : public FieldEditor {
 public:
  RowEditor(const std::vector<Field>& fields, std::size_t row) : fields_(fields), row_(row) {}

  void field(const FieldInfo&, const FieldSlot& slot) override {
    const Field& field = fields_[next_++];
    const std::size_t at = element_ ? *element_ : row_;
    if (next_ == end_) element_.reset();
    std::visit(Overloaded{[&](const std::span<double>& values) {
                            for (std::size_t i = 0; i < values.size(); ++i) {
                              if (field.columns[i].given) values[i] = number(field.columns[i], at);
                            }
                          },
                          [&](int* value) { *value = static_cast<int>(number(field.columns[0], at, *value)); },
                          [&](bool* value) { *value = number(field.columns[0], at, *value ? 1.0 : 0.0) != 0.0; },
                          [&](const WordSlot& word) {
                            if (field.columns[0].given)
                              word.assign(word.value, static_cast<int>(number(field.columns[0], at)));
                          },
                          [&](std::vector<float>* values) {
                            const auto [from, to] = span(field.columns[0], 1);
                            const std::vector<float>& all = field.columns[0].floats;
                            if (field.columns[0].given) values->assign(all.begin() + from, all.begin() + to);
                          },
                          [&](std::vector<Eigen::Vector3f>* points) {
                            const auto [from, to] = span(field.columns[0], 3);
                            points->reserve(static_cast<std::size_t>(to - from) / 3);
                            for (auto i = from; i < to; i += 3)
                              points->emplace_back(&field.columns[0].floats[static_cast<std::size_t>(i)]);
                          },
                          [&](std::vector<std::uint8_t>* bytes) {
                            const auto [from, to] = span(field.columns[0], 1);
                            const std::vector<std::uint8_t>& all = field.columns[0].bytes;
                            if (field.columns[0].given) bytes->assign(all.begin() + from, all.begin() + to);
                          }},
               slot);
  }

  std::size_t list(const FieldInfo&) override {
    list_ = next_++;
    end_ = next_ + fields_[list_].spec.elements;
    next_ = end_;  // if there is no element
    if (fields_[list_].size_from == 0) return 0;
    const std::vector<std::size_t>& begins = begins_of(fields_[fields_[list_].size_from]);
    first_ = begins[row_];
    return begins[row_ + 1] - first_;
  }

  void element(std::size_t index) override {
    next_ = list_ + 1;
    element_ = first_ + index;
  }

 private:
  double number(const Column& column, std::size_t at, double otherwise = 0.0) const {
    return column.given ? column.numbers[column.at(at)] : otherwise;
  }
  std::pair<std::ptrdiff_t, std::ptrdiff_t> span(const Column& column, std::size_t each) const {
    if (!column.given) return {0, 0};
    return {static_cast<std::ptrdiff_t>(each * column.begins[row_]),
            static_cast<std::ptrdiff_t>(each * column.begins[row_ + 1])};
  }

  const std::vector<Field>& fields_;
  std::size_t row_;
  std::size_t next_ = 0;
  std::size_t list_ = 0;
  std::size_t end_ = 0;    // behind the fields of the list's elements
  std::size_t first_ = 0;  // element of the row's list
  std::optional<std::size_t> element_;
};

PayloadColumns::PayloadColumns(std::string_view sensor, std::string_view payload, const py::dict& columns,
                               std::size_t rows)
    : sensor_(sensor), rows_(rows) {
  if (payload.empty()) {
    const std::vector<std::string> types = types_with(columns);
    if (types.size() != 1) {
      fail((types.empty() ? "no payload has just these fields: " : "several payloads have these fields: ") +
           joined(column_names(columns)) + (types.empty() ? "" : " (" + joined(types) + ")") +
           "; name one with payload=");
    }
    type_ = types.front();
  } else {
    type_ = find_payload_type(payload);
    if (type_.empty()) {
      std::vector<std::string> names;
      for (const std::string_view type : payload_types()) names.emplace_back(short_type_name(type));
      fail("\"" + std::string(payload) + "\" is no known payload; there are " + joined(names));
    }
  }
  for (const KnownPayload& known : known_payloads()) {
    if (known.type == type_) new_payload_ = known.make;
  }
  const std::vector<FieldSpec> specs = fields_of(*new_payload_());
  for (const FieldSpec& spec : specs) fields_.push_back({spec, std::vector<Column>(4), 0});
  const std::vector<std::string> names = names_of(specs);
  for (const auto& item : columns) {
    const auto name = py::cast<std::string>(item.first);
    bool is_known = false;
    std::size_t list = 0;
    std::size_t left = 0;
    for (std::size_t f = 0; f < fields_.size(); ++f) {
      const bool is_of_element = left > 0;
      if (left > 0) --left;
      if (fields_[f].spec.kind == Kind::list) {
        list = f;
        left = fields_[f].spec.elements;
        continue;
      }
      for (std::size_t i = 0; i < fields_[f].columns.size(); ++i) {
        if (fields_[f].spec.info.names[i] != name) continue;
        is_known = true;
        try {
          read(fields_[f], i, is_of_element, item.second);
        } catch (const DataError& error) {
          fail(name + ": " + error.what());
        }
        if (is_of_element && fields_[list].size_from == 0) fields_[list].size_from = f;
      }
    }
    if (!is_known) {
      const std::string nearest = nearest_name(name, names);
      fail(std::string(short_type_name(type_)) + " has no field \"" + name + "\"" +
           (nearest.empty() ? "; it has " + joined(names) : "; did you mean \"" + nearest + "\"?"));
    }
  }
  if (const std::vector<std::string> missing = missing_in(specs, columns); !missing.empty()) {
    fail(std::string(short_type_name(type_)) + " needs " + joined(missing));
  }
  check_lists();
}

const std::vector<std::size_t>& PayloadColumns::begins_of(const Field& field) {
  return std::ranges::find(field.columns, true, &Column::given)->begins;
}

void PayloadColumns::fail(std::string_view what) const {
  throw DataError("feed \"" + sensor_ + "\": " + std::string(what));
}

void PayloadColumns::read(Field& field, std::size_t name, bool is_of_element, const py::handle& value) {
  Column& column = field.columns[name];
  column.given = true;
  if (is_list(field.spec.kind) || is_of_element) {
    read_lists(field, column, value);
  } else {
    read_scalars(field, column, value);
  }
}

void PayloadColumns::read_scalars(Field& field, Column& column, const py::handle& value) const {
  if (field.spec.kind == Kind::word) {
    const auto number_of = [&](const std::string& word) {
      const auto& words = field.spec.info.words;
      const auto found = std::ranges::find(words, word);
      if (found == words.end()) {
        throw DataError("\"" + word + "\" is none of " + joined(std::vector<std::string>(words.begin(), words.end())));
      }
      return static_cast<double>(found - words.begin());
    };
    if (py::isinstance<py::str>(value)) {
      column.numbers.push_back(number_of(py::cast<std::string>(value)));
    } else {
      for (const py::handle word : value) column.numbers.push_back(number_of(py::cast<std::string>(py::str(word))));
    }
  } else {
    const auto array = array_of<double>(value);
    if (array.ndim() > 1)
      throw DataError("an array of " + std::to_string(array.ndim()) +
                      " dimensions; expected one value per measurement");
    column.numbers.assign(array.data(), array.data() + array.size());
    const auto is_no_int = [](double v) { return !(std::abs(v) < 2147483648.0) || v != std::floor(v); };
    if (field.spec.kind == Kind::integer && std::ranges::any_of(column.numbers, is_no_int))
      throw DataError("expected integers");
  }
  if (column.numbers.size() != 1 && column.numbers.size() != rows_) {
    throw DataError(std::to_string(column.numbers.size()) + " values for " + std::to_string(rows_) + " stamps");
  }
}

void PayloadColumns::read_lists(const Field& field, Column& column, const py::handle& value) const {
  if (!py::isinstance<py::sequence>(value) && !py::isinstance<py::array>(value))
    throw DataError("expected an array per measurement");
  const auto rows = py::reinterpret_borrow<py::object>(value);
  if (py::len(rows) != rows_)
    throw DataError(std::to_string(py::len(rows)) + " arrays for " + std::to_string(rows_) + " stamps");
  column.begins.reserve(rows_ + 1);
  column.begins.push_back(0);
  for (const py::handle row : rows) {
    std::size_t count = 0;
    if (field.spec.kind == Kind::bytes) {
      if (py::isinstance<py::bytes>(row)) {
        const auto text = py::cast<std::string_view>(row);
        column.bytes.insert(column.bytes.end(), text.begin(), text.end());
        count = text.size();
      } else {
        const auto array = array_of<std::uint8_t>(row);
        column.bytes.insert(column.bytes.end(), array.data(), array.data() + array.size());
        count = static_cast<std::size_t>(array.size());
      }
    } else if (field.spec.kind == Kind::numbers || field.spec.kind == Kind::points) {
      const auto array = array_of<float>(row);
      if (field.spec.kind == Kind::points && (array.ndim() != 2 || array.shape(1) != 3))
        throw DataError("expected an array with three columns per measurement");
      column.floats.insert(column.floats.end(), array.data(), array.data() + array.size());
      count = static_cast<std::size_t>(array.size()) / (field.spec.kind == Kind::points ? 3 : 1);
    } else {
      const auto array = array_of<double>(row);
      column.numbers.insert(column.numbers.end(), array.data(), array.data() + array.size());
      count = static_cast<std::size_t>(array.size());
    }
    column.begins.push_back(column.begins.back() + count);
  }
}

/// The fields of one list's elements must have equally many values.
void PayloadColumns::check_lists() const {
  for (std::size_t f = 0; f < fields_.size(); ++f) {
    if (fields_[f].spec.kind != Kind::list || fields_[f].size_from == 0) continue;
    const std::vector<std::size_t>& begins = begins_of(fields_[fields_[f].size_from]);
    for (std::size_t of_element = f + 1; of_element <= f + fields_[f].spec.elements; ++of_element) {
      const FieldSpec& spec = fields_[of_element].spec;
      if (is_list(spec.kind)) fail(std::string(spec.info.name()) + " is a list in each element, which cannot be given");
      for (std::size_t i = 0; i < fields_[of_element].columns.size(); ++i) {
        const Column& column = fields_[of_element].columns[i];
        if (column.given && column.begins != begins) {
          fail(std::string(spec.info.names[i]) + " and " + std::string(fields_[fields_[f].size_from].spec.info.name()) +
               " differ in their number of elements");
        }
      }
    }
  }
}

std::shared_ptr<Payload> PayloadColumns::make(std::size_t row) const {
  std::shared_ptr<Payload> payload = new_payload_();
  RowEditor editor(fields_, row);
  payload->edit(editor);
  return payload;
}

}  // namespace waymark::python
