// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;

constexpr const char* kHeader = "# map frame (east north up), pose of base_link; timestamp_s x_m y_m z_m qx qy qz qw";

TEST(TumSink, WritesTheOnlineEstimateAfterEveryMeasurement) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  sink->write(snapshot.at(0.5, Pose::planar(1.0, -2.0, 0.0)));
  sink->write(snapshot.at(1.25, Pose::planar(3.0, 4.0, std::numbers::pi / 2)));
  sink->finish(&snapshot, {});
  const auto lines = out.lines("trajectory.txt");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0], kHeader);
  EXPECT_EQ(lines[1], "0.500000000 1.000000 -2.000000 0.000000 0.000000000 0.000000000 0.000000000 1.000000000");
  EXPECT_EQ(lines[2], "1.250000000 3.000000 4.000000 0.000000 0.000000000 0.000000000 0.707106781 0.707106781");
}

TEST(TumSink, WritesCovariancesAtMappingStepsAsSoonAsThereAreAny) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  sink->write(snapshot.at(0.5, Pose{}));
  snapshot.fate_ = Fate::mapped;
  snapshot.mapping_steps_ = 1;
  sink->write(snapshot.at(1.0, Pose{}));
  snapshot.fate_ = Fate::fused;
  sink->write(snapshot.at(1.5, Pose{}));
  sink->finish(&snapshot, {});
  const auto lines = out.lines("covariance.csv");
  ASSERT_EQ(lines.size(), 3u) << "between mapping steps particles have been sampled, and the covariance says less";
  EXPECT_EQ(lines[0], "t_s,xx,xy,xyaw,yy,yyaw,yawyaw");
  EXPECT_EQ(lines[1].substr(0, 12), "0.500000000,");
  EXPECT_EQ(lines[2].substr(0, 12), "1.000000000,");
}

TEST(TumSink, WritesNoOtherCovariancesOfARunThatIsResumed) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.mapping_steps_ = 7;  // before the checkpoint
  sink->write(snapshot.at(0.5, Pose{}));
  snapshot.fate_ = Fate::mapped;
  sink->write(snapshot.at(1.0, Pose{}));
  sink->finish(&snapshot, {});
  const auto lines = out.lines("covariance.csv");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1].substr(0, 12), "1.000000000,");
}

TEST(TumSink, KeepsEveryNanosecondOfALargeStamp) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.belief_.stamp = Time{Duration{1248272272841000001}};
  sink->write(snapshot);
  sink->finish(&snapshot, {});
  EXPECT_EQ(out.lines("trajectory.txt").at(1).substr(0, 20), "1248272272.841000001");
}

TEST(TumSink, WritesOneSignOfTheQuaternion) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  Pose pose = Pose::planar(0.0, 0.0, 1.0);
  sink->write(snapshot.at(1.0, pose));
  pose.q.coeffs() *= -1.0;
  sink->write(snapshot.at(1.0, pose));
  sink->finish(&snapshot, {});
  const auto lines = out.lines("trajectory.txt");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[1], lines[2]);
}

TEST(TumSink, LeavesOutWhatTheFilterDidNotTake) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  for (const Fate fate : {Fate::fused, Fate::gated, Fate::mapped, Fate::held_out, Fate::late, Fate::before_start,
                          Fate::unusable, Fate::ignored}) {
    snapshot.fate_ = fate;
    sink->write(snapshot);
  }
  snapshot.fate_ = Fate::fused;
  snapshot.started_ = false;
  sink->write(snapshot);
  sink->finish(&snapshot, {});
  EXPECT_EQ(out.lines("trajectory.txt").size(), 5u);
}

TEST(TumSink, WritesTheBestPathOfTheLastSnapshot) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.path_ = {{Time{from_seconds(1.0)}, Pose::planar(7.0, 8.0, 0.0)},
                    {Time{from_seconds(2.0)}, Pose::planar(9.0, 8.0, 0.0)}};
  sink->finish(&snapshot, {});
  const auto lines = out.lines("path.txt");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[2], "2.000000000 9.000000 8.000000 0.000000 0.000000000 0.000000000 0.000000000 1.000000000");
}

TEST(TumSink, ARunWithoutSnapshotsLeavesHeaders) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  sink->finish(nullptr, {});
  EXPECT_EQ(out.lines("trajectory.txt"), std::vector<std::string>{kHeader});
  EXPECT_EQ(out.lines("path.txt"), std::vector<std::string>{kHeader});
  EXPECT_FALSE(out.has("reference.txt"));
  EXPECT_FALSE(out.has("smoothed.txt"));
}

TEST(TumSink, WritesTheReferenceAndTheIdentityWhereYawIsUnknown) {
  const TemporaryFolder out;
  auto reference = std::make_shared<Reference>();
  reference->trajectory = {{Time{from_seconds(1.0)}, Pose::planar(1.0, 2.0, std::numbers::pi / 2), true},
                           {Time{from_seconds(2.0)}, Pose::planar(3.0, 4.0, std::numbers::pi / 2), false}};
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, reference});
  sink->finish(nullptr, {});
  const auto lines = out.lines("reference.txt");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[1], "1.000000000 1.000000 2.000000 0.000000 0.000000000 0.000000000 0.707106781 0.707106781");
  EXPECT_EQ(lines[2], "2.000000000 3.000000 4.000000 0.000000 0.000000000 0.000000000 0.000000000 1.000000000");
}

TEST(TumSink, ARobotInSpaceHasNoHeightOfAPlanarReference) {
  const TemporaryFolder out;
  auto reference = std::make_shared<Reference>();
  reference->trajectory = {{Time{from_seconds(1.0)}, Pose::planar(1.0, 2.0, 0.0), true, true},
                           {Time{from_seconds(2.0)}, Pose::planar(3.0, 4.0, 0.0), true, false}};
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, reference});
  FakeSnapshot snapshot(StateLayout::Motion::spatial);
  sink->write(snapshot.at(0.5, Pose{}));
  sink->finish(&snapshot, {});
  const auto lines = out.lines("reference.txt");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[1].substr(0, 33), "1.000000000 1.000000 2.000000 nan");
  EXPECT_EQ(lines[2].substr(0, 38), "2.000000000 3.000000 4.000000 0.000000");
}

TEST(TumSink, WritesTheSmoothedTrajectoryIfThereIsOne) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum");
  sink->start({out.path(), nullptr, nullptr});
  RunReport report;
  report.smoothed.push_back(
      {Time{from_seconds(1.0)}, Pose::planar(7.0, 8.0, 0.0), Eigen::Vector3d(4.0, 9.0, 1.0).asDiagonal()});
  sink->finish(nullptr, report);
  EXPECT_EQ(out.lines("smoothed.txt").at(1),
            "1.000000000 7.000000 8.000000 0.000000 0.000000000 0.000000000 0.000000000 1.000000000");
  EXPECT_EQ(out.lines("smoothed_covariance.csv").at(1),
            "1.000000000,4.000000e+00,0.000000e+00,0.000000e+00,9.000000e+00,0.000000e+00,1.000000e+00");
}

TEST(TumSink, TakesFileNamesFromTheYaml) {
  const TemporaryFolder out;
  const auto sink = make_sink("tum", "{ trajectory: a.txt, path: b.txt }");
  sink->start({out.path(), nullptr, nullptr});
  sink->finish(nullptr, {});
  EXPECT_TRUE(out.has("a.txt"));
  EXPECT_TRUE(out.has("b.txt"));
  EXPECT_FALSE(out.has("trajectory.txt"));
}

TEST(TumSink, RefusesOneFileForTwoOutputs) {
  EXPECT_THROW(make_sink("tum", "{ path: trajectory.txt }"), ConfigError);
  EXPECT_THROW(make_sink("tum", "{ reference: path.txt }"), ConfigError);
}

}  // namespace
}  // namespace waymark
