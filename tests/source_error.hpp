// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "waymark/interface/source.hpp"

namespace waymark::test {

/// The message of the E that a source throws when `make()` constructs it or while it is read to its end; a failure of
/// the test if it throws none.
template <class E, class Make>
std::string source_error(const Make& make) {
  try {
    const auto source = make();
    while (source->next()) {
    }
  } catch (const E& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

}  // namespace waymark::test
