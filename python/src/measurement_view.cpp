// SPDX-License-Identifier: Apache-2.0
#include "measurement_view.hpp"

#include <pybind11/numpy.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "payload_columns.hpp"
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
  /// `elements`: how many fields the elements of each list of the payload have; of one that is not among them, all that
  /// follow.
  FieldReader(py::dict& out, const std::vector<std::size_t>& elements) : out_(out), fields_of_elements_(elements) {}

  void field(const FieldInfo& info, const FieldValue& value) override {
    py::dict& out = is_element_ ? element_ : out_;
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
    if (is_element_ && ++count_ == of_element_) end();
  }
  void list(const FieldInfo& info, std::size_t) override {
    elements_ = py::list();
    out_[text_of(info.name())] = elements_;
    of_element_ = lists_ < fields_of_elements_.size() ? fields_of_elements_[lists_] : 0;
    ++lists_;
  }
  void element(std::size_t) override {
    end();
    element_ = py::dict();
    is_element_ = true;
    count_ = 0;
  }
  /// After the last field.
  void end() {
    if (std::exchange(is_element_, false)) elements_.append(namespace_of(element_));
  }

 private:
  py::dict& out_;
  const std::vector<std::size_t>& fields_of_elements_;
  std::size_t lists_ = 0;
  std::size_t of_element_ = 0;  // fields; 0: unknown
  py::list elements_;
  py::dict element_;
  bool is_element_ = false;
  std::size_t count_ = 0;  // fields of this element so far
};

/// How many fields the elements of each list of a payload have; empty for one that is not registered. The GIL is held,
/// which guards the memory of it.
const std::vector<std::size_t>& fields_of_elements(std::string_view type) {
  static std::map<std::string, std::vector<std::size_t>, std::less<>> known;
  const auto found = known.find(type);
  if (found != known.end()) return found->second;
  std::vector<std::size_t> counts;
  if (const std::shared_ptr<Payload> payload = make_payload(type)) {
    for (const FieldSpec& spec : fields_of(*payload)) {
      if (spec.kind == FieldSpec::Kind::list) counts.push_back(spec.elements);
    }
  }
  return known.emplace(type, std::move(counts)).first->second;
}

}  // namespace

py::object view_of(const Measurement& measurement) {
  py::dict fields;
  fields["stamp_ns"] = nanoseconds(measurement.stamp);
  fields["arrival_ns"] = nanoseconds(measurement.arrival);
  fields["type"] = text_of(short_type_name(measurement.payload->type()));
  FieldReader reader(fields, fields_of_elements(measurement.payload->type()));
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
