// SPDX-License-Identifier: Apache-2.0
// The record of a plugin in its library, read before anything of it is loaded.
#include "input.hpp"
#include "plugins/src/plugin_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  const auto file = fuzz::write("waymark_fuzz.so", fuzz::text_of(data, size));
  fuzz::expect_value_or_error([&] { (void)misfit(read_plugin_record(file)); }, file.string());
  return 0;
}
