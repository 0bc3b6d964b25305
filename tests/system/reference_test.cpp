// SPDX-License-Identifier: Apache-2.0
// The keys that plugins declare, and the pages made of them.
#include "waymark/host/reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "command.hpp"

namespace waymark::system_test {
namespace {

PluginLoader shipped_plugins() {
  const std::filesystem::path program = WAYMARK_BINARY;
  return PluginLoader({program.parent_path().parent_path() / "lib/waymark/plugins"});
}

/// The host reads these of the same block and declares them.
bool is_of_host(const std::string& key) { return key == "name"; }

TEST(Reference, EveryKeyOfAPluginIsDeclared) {
  const PluginLoader loader = shipped_plugins();
  int plugins = 0;
  for (const PluginInfo& plugin : loader.list()) {
    ++plugins;
    for (const DescribedKey& key : host::plugin_keys(loader, plugin)) {
      const bool is_declared = !key.asked.meaning.empty() || is_of_host(key.asked.path);
      const bool is_read = key.asked.type != Config::Asked::Type::none;
      EXPECT_TRUE(is_declared || !is_read) << plugin.name << ": " << key.asked.path << " has no meaning";
    }
  }
  EXPECT_GT(plugins, 20);
}

TEST(Reference, EveryKeyOfTheRobotIsDeclared) {
  const std::vector<DescribedKey> keys = host::robot_keys();
  EXPECT_GT(keys.size(), 60U);
  for (const DescribedKey& key : keys) EXPECT_FALSE(key.asked.meaning.empty()) << key.asked.path;
}

TEST(Reference, ThePagesShowWhatIsDeclared) {
  const TemporaryFolder folder;
  const std::string report = folder / "report";
  const std::string check =
      WAYMARK_SOURCE_DIR "/docs/update_keys --check --waymark " WAYMARK_BINARY " > " + report + " 2>&1";
  EXPECT_EQ(std::system(check.c_str()), 0) << read_text(report);
}

TEST(Reference, TheCommandListsAPluginsKeys) {
  const Outcome keys = waymark({"plugins", "odometry"});
  EXPECT_EQ(keys.exit_code, 0) << keys.err;
  EXPECT_NE(keys.out.find("track_m [m]: number > 0, required\n      differential: distance between the wheels"),
            std::string::npos)
      << keys.out;
}

TEST(Reference, AnUnknownPluginIsAnErrorWithTheNearestName) {
  EXPECT_TRUE(reports_error(waymark({"plugins", "odometri"}), 1,
                            {"there is no plugin \"odometri\"", "did you mean \"odometry\"?", "dgps"}));
}

}  // namespace
}  // namespace waymark::system_test
