// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "waymark/interface/measurement.hpp"

namespace waymark::python {

/// A measurement for Python: stamp_ns, arrival_ns, type ("LaserScan") and the registered fields of its payload by their
/// names. Lists of numbers are arrays, points arrays (n, 3), elements of lists objects with their fields.
pybind11::object view_of(const Measurement& measurement);

/// Throws DataError if the payload is another than the one that a class takes: "LaserScan", "waymark/LaserScan@1", or
/// empty for any.
void require_payload(const Measurement& measurement, const std::string& taken);

}  // namespace waymark::python
