// SPDX-License-Identifier: Apache-2.0
// Runs the contract kit on our sink: prints all violations, and fails if there is one.
#include "distance.cpp"
#include "waymark/testing.hpp"

int main() { return testing::report({testing::check_sink<Distance>("{ file: distance.csv }")}); }
