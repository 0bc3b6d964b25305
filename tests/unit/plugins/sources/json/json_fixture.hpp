// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <memory>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::json_test {

/// A message of the wheels.
inline std::string wheels(double left, const std::string& more = "") {
  return fmt::format("{{\"sensor\":\"wheels\",\"left_mps\":{},\"right_mps\":2{}}}\n", left, more);
}

class Json : public ::testing::Test {
 protected:
  /// The source with two sensors; `more` says where the lines come from.
  std::shared_ptr<Source> make(const std::string& more) const {
    const std::string yaml =
        "channels: [{ sensor: wheels, payload: WheelSpeeds }, { sensor: gps, payload: waymark/GnssFix@1 }]\n" + more;
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    auto source =
        PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("json", config, Rig({{"wheels", "", {}}, {"gps", "", {}}}));
    config.reject_unread();
    return source;
  }

  test::TemporaryFolder folder_;
};

}  // namespace waymark::json_test
