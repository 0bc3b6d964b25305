// SPDX-License-Identifier: Apache-2.0
// needs plugins: ros2_publisher
#include <gtest/gtest.h>

#include "dds_domain.hpp"
#include "our_plugins.hpp"
#include "waymark/testing/sink_contract.hpp"

namespace waymark::contract_test {
namespace {

TEST(OurRos2Publisher, KeepsTheContract) {
  const auto make = [](const Config& config, const Rig& rig) {
    return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sink>("ros2_publisher", config, rig);
  };
  testing::SinkSetting setting;
  setting.run_config = "datum: { latitude_deg: 49, longitude_deg: 8 }\n";
  const std::string domain = "{ domain: " + std::to_string(test::own_domain());
  for (const char* more :
       {" }", ", when: committed, publish: [odometry, pose, fix, path, map, landmarks, diagnostics] }"})
    EXPECT_EQ(testing::to_text(testing::check_sink(make, domain + more, setting)), "") << more;
}

}  // namespace
}  // namespace waymark::contract_test
