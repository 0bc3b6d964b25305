// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/run_results.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

class RunResultsTest : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text = "1 2 3 4 5 6 7 8\n") {
    std::ofstream(out_ / name) << text;
  }
  test::TemporaryFolder out_;
};

TEST_F(RunResultsTest, AreFoundByTheNamesInTheConfiguration) {
  write("config.yaml", "sinks:\n  - { plugin: tum, trajectory: online.txt, reference: truth.txt }\n");
  write("online.txt");
  write("truth.txt");
  write("trajectory.txt");
  const RunResults found = find_results(out_.path());
  EXPECT_EQ(found.estimate, out_ / "online.txt");
  EXPECT_EQ(found.reference, out_ / "truth.txt");
  EXPECT_TRUE(found.covariance.empty());
}

TEST_F(RunResultsTest, AreFoundByTheUsualNamesWithoutAConfiguration) {
  write("trajectory.txt");
  write("covariance.csv");
  const RunResults found = find_results(out_.path());
  EXPECT_EQ(found.estimate, out_ / "trajectory.txt");
  EXPECT_EQ(found.covariance, out_ / "covariance.csv");
}

TEST_F(RunResultsTest, FixesThatWereHeldOutAreTheReferenceWithTheirLeverArm) {
  write("config.yaml",
        "sensors:\n  - { name: wheels, plugin: odometry }\n"
        "  - { name: gps, plugin: dgps, base_p_antenna_m: [0.5, 0, 1] }\n"
        "datum: { latitude_deg: 49, longitude_deg: 8.4 }\n");
  write("trajectory.txt");
  write("held_out.csv", "t_s,sensor,x_m,y_m,z_m,latitude_deg,longitude_deg,height_m\n1.0,gps,,,,49.0,8.4,\n");
  const RunResults found = find_results(out_.path());
  EXPECT_EQ(found.reference, out_ / "held_out.csv");
  ASSERT_TRUE(found.lever_arm_m);
  EXPECT_EQ(*found.lever_arm_m, Eigen::Vector3d(0.5, 0.0, 1.0));
  ASSERT_TRUE(found.datum);
  EXPECT_EQ(found.datum->longitude_deg, 8.4);
}

TEST_F(RunResultsTest, TheDatumThatTheRunChoseIsInItsDiagnostics) {
  write("trajectory.txt");
  write("diagnostics.json", R"({"datum": {"latitude_deg": 49.5, "longitude_deg": 8.5, "height_m": 110.0}})");
  const RunResults found = find_results(out_.path());
  ASSERT_TRUE(found.datum);
  EXPECT_EQ(found.datum->height_m, 110.0);
}

TEST_F(RunResultsTest, AFolderWithoutATrajectoryIsAnError) {
  try {
    find_results(out_.path());
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("has no trajectory.txt; the sink tum writes it"));
  }
  EXPECT_THROW(find_results(out_ / "nowhere"), Error);
}

}  // namespace
}  // namespace waymark::evaluation
