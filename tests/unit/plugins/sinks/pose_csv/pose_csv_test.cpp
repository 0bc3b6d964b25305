// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;

class PoseCsvSink : public testing::Test {
 protected:
  std::vector<std::string> fields_after(const FakeSnapshot& snapshot) {
    const auto sink = make_sink("pose_csv");
    sink->start({out_.path(), nullptr, nullptr});
    sink->write(snapshot);
    sink->finish(&snapshot, {});
    std::vector<std::string> fields;
    std::istringstream line(out_.lines("poses.csv").at(1));
    for (std::string field; std::getline(line, field, ',');) fields.push_back(field);
    return fields;
  }
  TemporaryFolder out_;
};

TEST_F(PoseCsvSink, WritesPoseVelocityAndSigmas) {
  FakeSnapshot snapshot;
  snapshot.at(2.5, Pose::planar(1.0, -2.0, std::numbers::pi / 2)).pose_variance(0.04, 0.09, 0.0001);
  snapshot.belief_.mean.v_base = {1.5, 0.0, 0.0};
  const auto fields = fields_after(snapshot);
  ASSERT_EQ(fields.size(), 22u);
  EXPECT_EQ(fields[0], "2.500000000");
  EXPECT_EQ(fields[1], "1.000000");
  EXPECT_EQ(fields[2], "-2.000000");
  EXPECT_EQ(fields[9], "1.570796");
  EXPECT_EQ(fields[10], "1.500000");
  EXPECT_EQ(fields[16], "0.200000");
  EXPECT_EQ(fields[17], "0.300000");
  EXPECT_EQ(fields[21], "0.010000");
}

TEST_F(PoseCsvSink, WhatPlanarMotionHoldsFixedHasNoSigma) {
  FakeSnapshot snapshot;
  const auto fields = fields_after(snapshot.at(1.0, Pose{}));
  for (const std::size_t sigma : {18u, 19u, 20u}) EXPECT_EQ(fields.at(sigma), "");
}

TEST_F(PoseCsvSink, WithADatumItHasThePlaceOnTheEarth) {
  FakeSnapshot snapshot;
  snapshot.at(1.0, Pose{});
  EXPECT_EQ(fields_after(snapshot).at(4), "");
  snapshot.datum_ = Datum{49.0, 8.4, 110.0};
  const auto fields = fields_after(snapshot);
  EXPECT_EQ(fields.at(4), "49.0000000000");
  EXPECT_EQ(fields.at(5), "8.4000000000");
  EXPECT_EQ(fields.at(6), "110.000000");
}

/// A spatial snapshot.
class Spatial : public FakeSnapshot {
 public:
  Spatial() { belief_.P = ErrorMatrix::Zero(spatial_.size(), spatial_.size()); }
  const StateLayout& layout() const override { return spatial_; }
  StateLayout spatial_{StateLayout::Motion::spatial, {}};
};

TEST_F(PoseCsvSink, TheSigmasOfTheAnglesAreThoseOfRollPitchYaw) {
  // The error is a rotation about the map's axes: of a base that looks north, roll is about north.
  Spatial snapshot;
  snapshot.at(1.0, Pose::planar(0.0, 0.0, std::numbers::pi / 2));
  snapshot.belief_.P(3, 3) = 0.01;    // about east: pitch
  snapshot.belief_.P(4, 4) = 0.0004;  // about north: roll
  snapshot.belief_.P(5, 5) = 0.0009;
  const auto fields = fields_after(snapshot);
  EXPECT_EQ(fields.at(19), "0.020000");
  EXPECT_EQ(fields.at(20), "0.100000");
  EXPECT_EQ(fields.at(21), "0.030000");
}

TEST_F(PoseCsvSink, TheSigmasAreThoseOfADerivativeTakenNumerically) {
  const Eigen::Vector3d rpy(0.3, -0.4, 1.1);
  Spatial snapshot;
  snapshot.at(1.0, Pose{so3::from_rpy(rpy.x(), rpy.y(), rpy.z()), Eigen::Vector3d::Zero()});
  Eigen::Matrix3d A;
  A << 0.02, 0.005, -0.003, 0.0, 0.03, 0.004, 0.0, 0.0, 0.01;
  const Eigen::Matrix3d P = A * A.transpose();
  snapshot.belief_.P.block(3, 3, 3, 3) = P;
  Eigen::Matrix3d J;
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d turn = kStep * Eigen::Vector3d::Unit(i);
    J.col(i) = (so3::to_rpy(so3::exp(turn) * snapshot.belief_.mean.T_map_base.q) - rpy) / kStep;
  }
  const Eigen::Vector3d sigma = (J * P * J.transpose()).diagonal().cwiseSqrt();
  const auto fields = fields_after(snapshot);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(std::stod(fields.at(19 + i)), sigma[static_cast<Eigen::Index>(i)], 2e-6);
}

TEST_F(PoseCsvSink, LeavesRowsOutThatAreTooCloseTogether) {
  const auto sink = make_sink("pose_csv", "{every_s: 0.5}");
  sink->start({out_.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  for (const double t : {0.0, 0.2, 0.4, 0.6, 0.8, 1.2}) sink->write(snapshot.at(t, Pose{}));
  sink->finish(&snapshot, {});
  EXPECT_EQ(out_.lines("poses.csv").size(), 1u + 3u);
}

}  // namespace
}  // namespace waymark
