// SPDX-License-Identifier: Apache-2.0
// The record of a plugin in its library, read before anything of it is loaded.
#include "plugins/src/plugin_file.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::plugin_file_harness {
namespace {
void run(std::string_view input) {
  const auto file = write("waymark_fuzz.so", input);
  expect_value_or_error([&] { (void)misfit(read_plugin_record(file)); }, file.string());
}

const Harness kHarness("plugin_file", run);

}  // namespace
}  // namespace waymark::fuzz::plugin_file_harness
