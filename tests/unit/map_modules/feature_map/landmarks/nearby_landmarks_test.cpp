// SPDX-License-Identifier: Apache-2.0
// The quick tests in front of the exact ones must never lose a landmark.
#include "map_modules/feature_map/landmarks/nearby_landmarks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "map_modules/feature_map/landmarks/visibility.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/math/random.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::kDegree;
using feature_map_test::landmark_at;

TEST(NearbyLandmarks, NoLandmarkWithinTheBoundIsLost) {
  Random random({.seed = 31, .slot = 0, .stamp = 0, .sensor = 0});
  for (const double where : {0.0, 1e5}) {  // far from the origin floats are coarse
    LandmarkStore store;
    for (int i = 0; i < 500; ++i)
      store.add(landmark_at(where + 20.0 * random.normal(), where + 20.0 * random.normal(), random.uniform()));
    NearbyLandmarks nearby;
    nearby.gather(store, {where, where}, 60.0);
    ASSERT_GT(nearby.size(), 450u);
    int exact = 0;
    int found_in_all = 0;
    for (int query = 0; query < 500; ++query) {
      const Eigen::Vector2d p(where + 20.0 * random.normal(), where + 20.0 * random.normal());
      // Bounds that one landmark meets exactly.
      const auto n = static_cast<std::size_t>(random.uniform() * static_cast<double>(nearby.size()));
      const double share = query % 2 == 0 ? 0.0 : 9.0 * random.uniform();
      const auto square = [&](const StoredLandmark& l) { return (l.mean().head<2>() - p).squaredNorm(); };
      const double base = std::max(0.0, square(nearby[n].landmark) - share * nearby[n].landmark.position_variance());
      const auto found = nearby.within(p, base, share);
      EXPECT_TRUE(std::ranges::is_sorted(found));
      found_in_all += static_cast<int>(found.size());
      for (std::size_t i = 0; i < nearby.size(); ++i) {
        if (square(nearby[i].landmark) > base + share * nearby[i].landmark.position_variance()) continue;
        ++exact;
        EXPECT_TRUE(std::ranges::binary_search(found, static_cast<std::uint32_t>(i)));
      }
    }
    EXPECT_LT(found_in_all, exact + exact / 50 + 500);  // and few come in vain
  }
}

/// What `should_be_seen` means, without any shortcut.
bool plainly_seen(const Eigen::Vector2d& p_map, double radius, const Pose& T_map_base, const ScanView& view,
                  const ExistenceSettings& settings) {
  const Eigen::Vector2d p_base =
      (T_map_base.inverse() * Eigen::Vector3d(p_map.x(), p_map.y(), T_map_base.p.z())).head<2>();
  const Eigen::Vector2d p_sensor = Eigen::Rotation2Dd(-view.yaw_base_sensor) * (p_base - view.p_base_sensor);
  const double distance = p_sensor.norm();
  const double bearing = std::atan2(p_sensor.y(), p_sensor.x());
  if (distance > settings.view_range || distance <= radius || std::abs(bearing) > settings.view_half_angle)
    return false;
  if (view.ranges.empty()) return true;
  const double half_width = std::asin(radius / distance);
  const double a = (bearing - half_width - view.start) / view.step;
  const double b = (bearing + half_width - view.start) / view.step;
  const auto low = static_cast<int>(std::floor(std::min(a, b)));
  const auto high = static_cast<int>(std::ceil(std::max(a, b)));
  if (low < 0 || high >= static_cast<int>(view.ranges.size())) return false;
  for (int i = low; i <= high; ++i) {
    if (view.ranges[static_cast<std::size_t>(i)] <= distance + settings.free_margin) return false;
  }
  return true;
}

TEST(ExpectedView, ItsShortcutsChangeNothing) {
  Random random({.seed = 32, .slot = 0, .stamp = 0, .sensor = 0});
  ExistenceSettings settings = feature_map_test::settings_of("{ existence: { view_range_m: 25 } }").existence;
  int seen = 0;
  for (int scene = 0; scene < 60; ++scene) {
    settings.view_half_angle = kDegree * (20.0 + 160.0 * random.uniform());
    ScanView view;
    view.p_base_sensor = {3.0 * random.normal(), random.normal()};
    view.yaw_base_sensor = random.normal();
    const bool backwards = scene % 3 == 1;  // a scanner that hangs upside down
    const double step = kDegree * (0.1 + random.uniform());
    view.start = backwards ? 1.6 : -1.6;
    view.step = backwards ? -step : step;
    if (scene % 3 != 2) {
      for (int i = 0; i * step < 3.2; ++i)
        view.ranges.push_back(random.uniform() < 0.2 ? static_cast<float>(30.0 * random.uniform()) : 80.0f);
    }
    const double tilt = scene % 2 == 0 ? 0.0 : 0.3;
    const Pose pose{so3::from_rpy(tilt * random.normal(), tilt * random.normal(), 3.0 * random.normal()),
                    {100.0 * random.normal(), 100.0 * random.normal(), random.normal()}};
    const ExpectedView expected(pose, view, settings);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d p = pose.p.head<2>() + 15.0 * Eigen::Vector2d(random.normal(), random.normal());
      const double radius = 0.5 * random.uniform();
      const bool plain = plainly_seen(p, radius, pose, view, settings);
      EXPECT_EQ(expected.should_show(p, radius), plain);
      if (plain) {
        EXPECT_LE((p - expected.center()).squaredNorm(), expected.reach_square());
      }
      seen += plain;
    }
  }
  EXPECT_GT(seen, 1000);
}

}  // namespace
}  // namespace waymark::feature_map
