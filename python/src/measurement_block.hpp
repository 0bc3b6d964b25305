// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "payload_columns.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::python {

/// A block of measurements of one sensor as it is given from Python: stamps, arrivals and the columns of a payload.
class MeasurementBlock {
 public:
  /// `arrivals`: None for the stamps. Throws TypeError and DataError, with `sensor` in its text, for what does not fit.
  /// The GIL is held.
  MeasurementBlock(const std::string& sensor, const pybind11::object& stamps, const pybind11::object& arrivals,
                   std::string_view payload, const pybind11::dict& columns);

  std::size_t size() const { return stamps_.size(); }
  std::string_view type() const { return values_.type(); }
  /// The measurements, of the sensor with this index, the first not before `last`. Throws DataError, which names the
  /// row, if they are not in order of arrival or have bad values. Needs no GIL.
  std::vector<Measurement> make(std::uint32_t index, Time last = Time::min()) const;

 private:
  [[noreturn]] void fail(const std::string& what) const;

  std::string sensor_;
  std::vector<std::int64_t> stamps_;
  std::vector<std::int64_t> arrivals_;
  PayloadColumns values_;
};

}  // namespace waymark::python
