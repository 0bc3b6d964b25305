// SPDX-License-Identifier: Apache-2.0
#include "measurement_block.hpp"

#include <pybind11/numpy.h>

#include <memory>
#include <utility>

#include "waymark/base/error.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

/// One int64 for every measurement.
std::vector<std::int64_t> stamps_of(const py::object& given, const std::string& sensor, const char* name) {
  const auto fail = [&](const std::string& what) {
    throw py::type_error("feed \"" + sensor + "\": " + name + ": " + what + "; expected int64 nanoseconds");
  };
  const auto array = py::array::ensure(given);
  if (!array || (array.dtype().kind() != 'i' && array.dtype().kind() != 'u')) {
    PyErr_Clear();
    fail(array ? "an array of " + py::cast<std::string>(py::str(array.dtype())) : "no array");
  }
  if (array.ndim() > 1) fail("an array of " + std::to_string(array.ndim()) + " dimensions");
  const auto numbers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>(array);
  return {numbers.data(), numbers.data() + numbers.size()};
}

}  // namespace

MeasurementBlock::MeasurementBlock(const std::string& sensor, const py::object& stamps, const py::object& arrivals,
                                   std::string_view payload, const py::dict& columns)
    : sensor_(sensor),
      stamps_(stamps_of(stamps, sensor, "stamps_ns")),
      arrivals_(arrivals.is_none() ? stamps_ : stamps_of(arrivals, sensor, "arrivals_ns")),
      values_(sensor, payload, columns, stamps_.size()) {
  if (arrivals_.size() != stamps_.size())
    fail(std::to_string(arrivals_.size()) + " arrivals for " + std::to_string(stamps_.size()) + " stamps");
}

void MeasurementBlock::fail(const std::string& what) const { throw DataError("feed \"" + sensor_ + "\": " + what); }

std::vector<Measurement> MeasurementBlock::make(std::uint32_t index, Time last) const {
  std::vector<Measurement> block;
  block.reserve(size());
  for (std::size_t row = 0; row < size(); ++row) {
    Measurement measurement;
    measurement.stamp = Time(Duration(stamps_[row]));
    measurement.arrival = Time(Duration(arrivals_[row]));
    measurement.sensor = index;
    if (!is_stamp(measurement.stamp) || !is_stamp(measurement.arrival))
      fail("row " + std::to_string(row) + ": a stamp further than 146 years from the epoch");
    if (measurement.arrival < last) {
      fail("row " + std::to_string(row) + ": arrives at " + format_time(measurement.arrival) + " s, before the row " +
           "that precedes it (" + format_time(last) +
           " s); measurements are fed in order of arrival, give arrivals_ns");
    }
    last = measurement.arrival;
    std::shared_ptr<Payload> made = values_.make(row);
    if (const std::string problem = made->problem(); !problem.empty())
      fail("row " + std::to_string(row) + ": " + problem);
    measurement.payload = std::move(made);
    block.push_back(std::move(measurement));
  }
  return block;
}

}  // namespace waymark::python
