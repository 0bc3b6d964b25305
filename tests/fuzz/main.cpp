// SPDX-License-Identifier: Apache-2.0
// What libFuzzer calls. One program with all harnesses takes a fraction of the time that one program for each took to
// compile and to link.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz {
namespace {

/// All harnesses. They enter themselves before main begins, in no certain order.
std::vector<const Harness*>& harnesses() {
  static std::vector<const Harness*> list;
  return list;
}

const Harness* selected = nullptr;

}  // namespace

Harness::Harness(std::string_view given_name, void (*given_run)(std::string_view)) : name(given_name), run(given_run) {
  harnesses().push_back(this);
}

}  // namespace waymark::fuzz

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** argv) {
  using namespace waymark::fuzz;
  const std::string called = std::filesystem::path((*argv)[0]).filename().string();
  for (const Harness* harness : harnesses()) {
    if (called == "fuzz_" + std::string(harness->name)) selected = harness;
  }
  if (selected != nullptr) return 0;
  std::fprintf(stderr, "%s: call this program by the name of a harness (a link to it):", called.c_str());
  for (const Harness* harness : harnesses()) std::fprintf(stderr, " fuzz_%s", std::string(harness->name).c_str());
  std::fprintf(stderr, "\n");
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  waymark::fuzz::selected->run(waymark::fuzz::text_of(data, size));
  return 0;
}
