// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/measurement.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark {

void Measurement::throw_wrong_type(std::string_view expected) const {
  throw DataError(fmt::format("a measurement at {} s carries {}, but {} was expected", format_time(stamp),
                              payload->type(), expected));
}

}  // namespace waymark
