// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waymark::testing {

/// What a plugin does against its interface's contract, one sentence each; empty is good. A check that fails often is
/// listed once.
using Violations = std::vector<std::string>;

/// One violation per line, for messages of any test framework.
std::string to_text(const Violations& violations);

}  // namespace waymark::testing
