// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/measurement.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark {

void Measurement::throw_wrong_type(std::string_view asked) const {
  throw DataError(fmt::format("a measurement at {} s carries {}, but {} was asked for", format_time(stamp),
                              payload->type(), asked));
}

}  // namespace waymark
