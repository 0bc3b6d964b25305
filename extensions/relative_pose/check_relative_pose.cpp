// SPDX-License-Identifier: Apache-2.0
// Checks of the sensor relative_pose: the contract kit in the plane and in space, and how it takes a jump, a
// lost track, and a mounting. Prints what is wrong, and fails if anything is.
#include <cmath>
#include <cstdio>

#include "relative_pose.cpp"
#include "waymark/testing.hpp"

namespace {

using namespace waymark;
using namespace waymark::relative;

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  ++failures;
  std::fprintf(stderr, "failed: %s\n", what);
}

constexpr const char* kYaml =
    "{ name: camera, max_speed_mps: 2, max_rate_degps: 90, max_acceleration_mps2: 2, max_angular_acceleration_degps2: "
    "200 }";
const Pose kMounting{so3::from_rpy(0.1, -0.2, 1.0), {0.4, 0.1, 0.6}};

Rig rig() { return Rig({{"camera", "", kMounting}}); }

/// Frames at 10 Hz; the 8th is a jump, the 12th and 13th are lost.
std::vector<Measurement> frames() {
  return testing::measurements_of<RelativePose>(20, 0.1, [](RelativePose& motion, double t) {
    const int k = static_cast<int>(std::lround(10.0 * t));
    motion.interval_s = 0.1;
    motion.p_m = {0.1 + 0.005 * std::sin(t), 0.01, k == 8 ? 3.0 : -0.02};
    motion.q = so3::from_rpy(0.01, 0.02, 0.03);
    if (k % 2 == 0) motion.sigma_p_m.setConstant(0.004);
    motion.tracked = k != 12 && k != 13;
  });
}

std::vector<Measurement> planar_frames() {
  return testing::measurements_of<PoseIncrement>(20, 0.1, [](PoseIncrement& motion, double t) {
    motion.interval_s = 0.1;
    motion.x_m = t > 1.05 && t < 1.15 ? -1.0 : 0.1;
    motion.yaw_rad = 0.02;
  });
}

struct Seen {
  Vector6 twist;
  double sigma;  // of v_x
  bool is_degraded;
};

/// What the sensor estimates from each frame: the twist of the base, as a robot that stands sees it.
std::vector<Seen> seen(RelativePoseSensor& sensor, const std::vector<Measurement>& measurements) {
  const StateLayout layout(StateLayout::Motion::spatial, {});
  Belief belief;
  belief.P = ErrorMatrix::Identity(layout.size(), layout.size());
  std::vector<Seen> all;
  all.reserve(measurements.size());
  for (const Measurement& m : measurements) {
    UpdateList updates;
    sensor.process(m, {belief, layout, nullptr, nullptr, false}, updates);
    Linearization out;
    updates[0].linearize({belief.mean, nullptr}, out);
    all.push_back({out.residual, std::sqrt(out.R(0, 0)), !updates.degraded_reason().empty()});
  }
  return all;
}

void check_resets() {
  RelativePoseSensor sensor(Config::parse(kYaml), rig());
  const std::vector<Seen> all = seen(sensor, frames());
  for (const std::size_t k : {8, 12, 13}) {
    expect(all[k].is_degraded, "a jump and a lost track are reported");
    expect((all[k].twist - all[k - (k == 13 ? 2 : 1)].twist).norm() < 1e-12, "the robot goes on as it moved");
    expect(all[k].sigma > 0.15, "with the uncertainty of what it can do meanwhile");
  }
  expect(all[13].sigma > all[12].sigma, "the longer, the more");
  for (const std::size_t k : {7, 9, 11, 14, 19}) expect(!all[k].is_degraded, "all other frames are believed");
}

/// A base that turns about itself: a camera on an arm moves sideways, and the base does not.
void check_mounting() {
  RelativePoseSensor sensor(Config::parse(kYaml), rig());
  const auto turning = testing::measurements_of<RelativePose>(1, 0.1, [](RelativePose& motion, double) {
    const Pose turn{so3::from_rpy(0.0, 0.0, 0.05), Eigen::Vector3d::Zero()};
    const Pose of_camera = kMounting.inverse() * turn * kMounting;
    motion.interval_s = 0.1;
    motion.p_m = of_camera.p;
    motion.q = of_camera.q;
  });
  const Vector6 twist = seen(sensor, turning).front().twist;
  expect(twist.head<3>().norm() < 1e-9, "the base does not move");
  expect((twist.tail<3>() - Eigen::Vector3d(0.0, 0.0, 0.5)).norm() < 1e-9, "the base turns");
}

}  // namespace

int main() {
  check_resets();
  check_mounting();
  const RelativePoseSensor sensor(Config::parse(kYaml), rig());
  return failures + testing::report({testing::check_sensor(sensor, frames(), StateLayout::Motion::spatial),
                                     testing::check_sensor(sensor, planar_frames(), StateLayout::Motion::planar),
                                     testing::check_keys<RelativePoseSensor>(kYaml, rig())});
}
