// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "our_plugins.hpp"
#include "waymark/testing/source_contract.hpp"

namespace waymark::contract_test {
namespace {

using testing::check_source;
using testing::to_text;

TEST(OurSources, TheSimulatorKeepsTheContract) {
  EXPECT_EQ(to_text(check_source([] { return make<Source>("simulator", kSimulation); })), "");
}

class OurCsv : public ::testing::Test {
 protected:
  OurCsv() : folder_(std::filesystem::temp_directory_path() / ("waymark_contract_csv_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    std::ofstream wheels(folder_ / "wheels.csv");
    std::ofstream scans(folder_ / "scans.csv");
    std::ofstream seen(folder_ / "seen.csv");
    wheels << "t,left,right\n";
    scans << "t,r0,r1,r2\n";
    seen << "t,range,bearing,id\n";
    for (int k = 0; k < 60; ++k) {
      wheels << 0.1 * k << "," << 1.0 + 0.01 * k << "," << (k == 17 ? "fault" : "1.1") << "\n";
      if (k % 3 == 0) scans << 0.1 * k << ",4.5," << 3.0 + 0.1 * k << ",81\n";
      if (k % 4 < 2) seen << 0.4 * (k / 4) << "," << 2.0 + 0.1 * k << ",0.2," << k % 4 << "\n";
    }
  }
  ~OurCsv() override { std::filesystem::remove_all(folder_); }

  std::shared_ptr<Source> source() const {
    const std::string yaml =
        "max_bad_rows: 1\n"
        "files:\n"
        "  - { path: wheels.csv, sensor: wheels, payload: WheelSpeeds, time: t, columns: { left_mps: left, right_mps: "
        "right } }\n"
        "  - { path: scans.csv, sensor: lidar, payload: LaserScan, time: t, arrival: { column: t, offset_s: 0.25 },"
        " columns: { ranges_m: { first: r0, last: r2 } }, scan: { start_deg: -1, step_deg: 1 } }\n"
        "  - { path: seen.csv, sensor: gps, payload: LandmarkObservations, time: t, group_by_time: true,"
        " columns: { range_m: range, bearing_rad: bearing, identity: id } }\n";
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("csv", config, rig());
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(OurCsv, KeepsTheContract) {
  EXPECT_EQ(to_text(check_source([&] { return source(); })), "");
}

}  // namespace
}  // namespace waymark::contract_test
