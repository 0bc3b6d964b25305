// SPDX-License-Identifier: Apache-2.0
// needs plugins: report
#include <gtest/gtest.h>

#include "our_plugins.hpp"
#include "waymark/testing/sink_contract.hpp"

namespace waymark::contract_test {
namespace {

TEST(OurReport, KeepsTheContract) {
  const auto make = [](const Config& config, const Rig& rig) {
    return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sink>("report", config, rig);
  };
  EXPECT_EQ(testing::to_text(testing::check_sink(make, "{ file: r.html }")), "");
}

}  // namespace
}  // namespace waymark::contract_test
