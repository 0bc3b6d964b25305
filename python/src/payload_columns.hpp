// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/interface/payloads.hpp"

namespace waymark::python {

/// A field of a payload as it can be given from Python.
struct FieldSpec {
  enum class Kind { number, integer, flag, word, numbers, points, bytes, list };
  FieldInfo info;
  Kind kind = Kind::number;
  std::size_t elements = 0;  ///< of a list: how many of the following specs are fields of its elements
};

/// The fields of a payload, in the order in which they are registered; those of a list's elements follow it.
std::vector<FieldSpec> fields_of(Payload& payload);

/// A block of measurements of one payload type, given as columns, one value or one array for every measurement. The
/// values are copied, so the arrays may be changed afterwards.
class PayloadColumns {
 public:
  /// `columns`: name of a field to its values: an array with one value for each of `rows` measurements, or one value
  /// for all. Lists (`ranges_m`) are two-dimensional arrays or sequences of arrays. `payload`: "WheelSpeeds" or
  /// "waymark/WheelSpeeds@1", of core or registered by a plugin; empty: the one that has these fields. Throws
  /// DataError, with `sensor` in its text, for names and sizes that do not fit.
  PayloadColumns(std::string_view sensor, std::string_view payload, const pybind11::dict& columns, std::size_t rows);

  std::string_view type() const { return type_; }
  /// The payload of one measurement; needs no GIL.
  std::shared_ptr<Payload> make(std::size_t row) const;

 private:
  class RowEditor;
  /// The values of one name of a field.
  struct Column {
    bool given = false;
    std::vector<double> numbers;      ///< one per measurement, or one for all, or one per element of a list
    std::vector<float> floats;        ///< of lists of numbers and of points
    std::vector<std::uint8_t> bytes;  ///< of bytes
    std::vector<std::size_t> begins;  ///< of lists: where each measurement's values begin, and the end of the last
    std::size_t at(std::size_t row) const { return numbers.size() == 1 ? 0 : row; }
  };
  struct Field {
    FieldSpec spec;
    std::vector<Column> columns;  ///< one per name
    std::size_t size_from = 0;    ///< of a list: the field of its elements that has their number; 0: none is given
  };
  /// Where each measurement's elements begin, of a field of elements that is given.
  static const std::vector<std::size_t>& begins_of(const Field& field);

  void read(Field& field, std::size_t name, bool is_of_element, const pybind11::handle& value);
  void read_scalars(Field& field, Column& column, const pybind11::handle& value) const;
  void read_lists(const Field& field, Column& column, const pybind11::handle& value) const;
  void check_lists() const;
  [[noreturn]] void fail(std::string_view what) const;

  std::string sensor_;
  std::string type_;
  std::size_t rows_;
  std::shared_ptr<Payload> (*new_payload_)() = nullptr;
  std::vector<Field> fields_;
};

}  // namespace waymark::python
