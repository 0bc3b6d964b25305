// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/base/api.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::fusion {

/// Writes a measurement with its payload's registered fields. Throws Error if it registers none.
WAYMARK_API void write_measurement(OutArchive& out, const Measurement& measurement);
/// Reads it. Throws DataError if the payload is not known, or has an invalid value.
WAYMARK_API Measurement read_measurement(InArchive& in);

}  // namespace waymark::fusion
