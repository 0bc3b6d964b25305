// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

namespace waymark::testing {

/// What a plugin does against its interface's contract, one sentence each; empty is good. A check that fails often is
/// listed once.
using Violations = std::vector<std::string>;

/// One violation per line, for messages of any test framework.
std::string to_text(const Violations& violations);

/// For the `main` of a check without a test framework: prints all violations on standard error, and returns the exit
/// code, 0 if there are none and 1 otherwise.
int report(std::initializer_list<Violations> checks);

}  // namespace waymark::testing
