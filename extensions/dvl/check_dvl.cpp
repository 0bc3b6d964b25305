// SPDX-License-Identifier: Apache-2.0
// Checks of the sensor dvl: the contract kit with three axes and with one, a lost ground, and a lever arm. Prints what
// is wrong, and fails if anything is.
#include <cmath>
#include <cstdio>

#include "dvl.cpp"
#include "waymark/testing.hpp"

namespace {

using namespace waymark;
using namespace waymark::dvl;

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  ++failures;
  std::fprintf(stderr, "failed: %s\n", what);
}

constexpr const char* kDvl = "{ name: dvl, scale_sigma: 0.01, max_speed_mps: 3, least_altitude_m: 0.3 }";
constexpr const char* kLog = "{ name: dvl, sigma_mps: 0.1 }";
const Pose kMounting{so3::from_rpy(3.14, 0.05, 0.8), {0.6, -0.1, -0.2}};

Rig rig() { return Rig({{"dvl", "", kMounting}}); }

std::vector<Measurement> velocities(int axes) {
  return testing::measurements_of<BottomVelocity>(20, 0.2, [axes](BottomVelocity& measured, double t) {
    for (int i = 0; i < axes; ++i) measured.v_mps[i] = 1.0 - 0.4 * i + 0.1 * t;
    measured.variance_m2ps2 = {0.01, 1e-9, BottomVelocity::kUnknown};
    measured.altitude_m = t > 2.9 && t < 3.1 ? 0.2 : 4.0;
    measured.locked = !(t > 0.9 && t < 1.1);
  });
}

struct Seen {
  Linearization rows;
  std::size_t updates;
  bool is_degraded;
};

Seen seen(const char* yaml, const BottomVelocity& measured, const NavState& state) {
  Dvl sensor(Config::parse(yaml), rig());
  const StateLayout layout(StateLayout::Motion::spatial, {});
  Measurement m;
  m.payload = std::make_shared<BottomVelocity>(measured);
  UpdateList updates;
  sensor.process(m, {{{}, state, ErrorMatrix::Identity(12, 12)}, layout, nullptr, nullptr, false}, updates);
  Seen found{{}, updates.size(), !updates.degraded_reason().empty()};
  const double scale = 0.0;
  if (updates.size() > 0) updates[0].linearize({state, &scale}, found.rows);
  return found;
}

void check_behaviour() {
  NavState turning;
  turning.w_base = {0.0, 0.0, 0.5};
  BottomVelocity measured;
  measured.v_mps = kMounting.q.conjugate() * turning.w_base.cross(kMounting.p);
  measured.variance_m2ps2 = {0.04, 1e-9, BottomVelocity::kUnknown};
  measured.altitude_m = 2.0;
  const Seen arm = seen(kDvl, measured, turning);
  expect(arm.rows.residual.norm() < 1e-12, "a vehicle that turns moves the instrument on its arm");
  expect(std::abs(arm.rows.R(0, 0) - 0.04) < 1e-12, "a reported variance above the floor counts");
  expect(std::abs(arm.rows.R(1, 1) - 1e-4) < 1e-12, "one below does not");
  measured.locked = false;
  const Seen lost = seen(kDvl, measured, turning);
  expect(lost.updates == 0 && lost.is_degraded, "without ground there is no update, and the sensor is degraded");
  measured.locked = true;
  measured.v_mps.x() = 4.0;
  const Seen fast = seen(kDvl, measured, turning);
  expect(fast.updates == 0 && fast.is_degraded, "nor with a velocity that cannot be");
  measured.v_mps.x() = BottomVelocity::kUnknown;
  expect(seen(kDvl, measured, turning).rows.rows() == 2, "an axis that is not known has no row");
}

}  // namespace

int main() {
  check_behaviour();
  return failures +
         testing::report(
             {testing::check_sensor(Dvl(Config::parse(kDvl), rig()), velocities(3), StateLayout::Motion::spatial),
              testing::check_sensor(Dvl(Config::parse(kLog), rig()), velocities(1), StateLayout::Motion::planar),
              testing::check_keys<Dvl>(kDvl, rig())});
}
