// SPDX-License-Identifier: Apache-2.0
#include "measurement_view.hpp"

#include <pybind11/numpy.h>

#include <string>
#include <variant>

#include "rows.hpp"
#include "waymark/base/error.hpp"
#include "waymark/base/overloaded.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

py::str text_of(std::string_view text) { return {text.data(), text.size()}; }

py::object namespace_of(const py::dict& fields) {
  return py::module_::import("types").attr("SimpleNamespace")(**fields);
}

class FieldReader final : public FieldVisitor {
 public:
  explicit FieldReader(py::dict& out) : out_(out) {}

  void field(const FieldInfo& info, const FieldValue& value) override {
    py::dict& out = left_ > 0 ? element_ : out_;
    std::visit(
        Overloaded{[&](const std::span<const double>& numbers) {
                     for (std::size_t i = 0; i < numbers.size(); ++i)
                       out[text_of(info.names[i])] = py::float_(numbers[i]);
                   },
                   [&](std::int64_t number) { out[text_of(info.name())] = py::int_(number); },
                   [&](bool flag) { out[text_of(info.name())] = py::bool_(flag); },
                   [&](const FieldWord& word) { out[text_of(info.name())] = text_of(word.word); },
                   [&](const std::span<const float>& list) {
                     out[text_of(info.name())] = py::array_t<float>(static_cast<py::ssize_t>(list.size()), list.data());
                   },
                   [&](const std::span<const Eigen::Vector3f>& points) {
                     const auto* data = points.empty() ? nullptr : points.front().data();
                     out[text_of(info.name())] =
                         py::array_t<float>({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}}, data);
                   },
                   [&](const std::span<const std::uint8_t>& bytes) {
                     out[text_of(info.name())] = py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                   }},
        value);
  }
  void list(const FieldInfo& info, std::size_t size) override {
    elements_ = py::list();
    out_[text_of(info.name())] = elements_;
    left_ = size;
  }
  void element(std::size_t index) override {
    if (index > 0) elements_.append(namespace_of(element_));
    element_ = py::dict();
  }
  /// After the last field.
  void end() {
    if (left_ > 0) elements_.append(namespace_of(element_));
  }

 private:
  py::dict& out_;
  py::list elements_;
  py::dict element_;
  std::size_t left_ = 0;  // elements of the list; no core payload has fields behind one
};

}  // namespace

py::object view_of(const Measurement& measurement) {
  py::dict fields;
  fields["stamp_ns"] = nanoseconds(measurement.stamp);
  fields["arrival_ns"] = nanoseconds(measurement.arrival);
  fields["type"] = text_of(short_type_name(measurement.payload->type()));
  FieldReader reader(fields);
  measurement.payload->visit(reader);
  reader.end();
  return namespace_of(fields);
}

void require_payload(const Measurement& measurement, const std::string& taken) {
  const std::string_view type = measurement.payload->type();
  if (taken.empty() || taken == type || taken == short_type_name(type)) return;
  throw DataError("payload " + std::string(type) + ", expected " + taken);
}

}  // namespace waymark::python
