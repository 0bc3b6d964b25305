// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/measurement.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::fusion {

/// Writes a measurement with its payload's registered fields. Throws Error if it registers none.
void write_measurement(OutArchive& out, const Measurement& measurement);
/// Reads it. Throws DataError if the payload is none of core's, or has an invalid value.
Measurement read_measurement(InArchive& in);

}  // namespace waymark::fusion
