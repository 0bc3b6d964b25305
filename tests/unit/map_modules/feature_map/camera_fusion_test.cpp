// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// A robot in a curve whose camera is a tenth of a second ahead of its scanner, and then fails.
#include <gtest/gtest.h>

#include <map>

#include "tests/unit/map_modules/feature_map/camera_bench.hpp"
#include "unit/core/fusion_robot.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::CameraScene;
using feature_map_test::kRedPaint;
using test::reading;
using test::twist;

constexpr std::uint32_t kCamera = 1;
constexpr std::uint32_t kLidar = 2;
constexpr double kSpeed = 0.5;
constexpr double kTurn = 0.5;  // [rad/s]

// What is tested is the camera, so the odometry is as good as its numbers.
const std::string kGoodWheels =
    "  - { name: wheels, plugin: odometry, model: twist, speed_noise_m_per_sqrt_s: [0.002, 0],"
    " lateral_noise_m_per_sqrt_s: [0.002, 0], yaw_noise_rad_per_sqrt_s: [0.001, 0, 0],"
    " speed_scale_sigma: 0, curvature_sigma_per_m: 0, yaw_scale_sigma: 0 }\n";

class CameraInAFusion : public ::testing::Test {
 protected:
  /// Things stand in the map; the robot starts at its origin.
  static Pose true_pose(double t) { return MotionWindow{{kSpeed, 0.0, 0.0}, {0.0, 0.0, kTurn}}.relative(t); }
  Measurement scan(double t) const {
    CameraScene seen = scene_;
    for (auto& thing : seen.things) {
      thing.center = (true_pose(t).inverse() * Eigen::Vector3d(thing.center.x(), thing.center.y(), 0.0)).head<2>();
    }
    return reading(t, kLidar, std::make_shared<LaserScan>(seen.scan()));
  }
  Measurement image(double t) const { return reading(t, kCamera, scene_.image(scene_.picture(true_pose(t))).payload); }
  MapSlot map_slot() const {
    const Config config =
        Config::parse("{ name: trees, plugin: feature_map, inputs: [lidar, front], attributes: [radius, signature] }");
    const Rig rig({{"wheels", "", {}},
                   {"front", "waymark/Image@1", scene_.T_base_camera, scene_.intrinsics},
                   {"lidar", "waymark/LaserScan@1", scene_.T_base_scanner}});
    MapSlot slot = read_map_slot(config, rig);
    slot.module = PluginLoader({WAYMARK_PLUGIN_DIR}).create<MapModule>("feature_map", config, rig);
    return slot;
  }

  CameraScene scene_{{{{6.0, 1.8}, 0.2, kRedPaint}}};
};

TEST_F(CameraInAFusion, ImagesArePairedMovedByTheTurnAndDoneWithoutWhenTheyStop) {
  std::vector<Measurement> log;
  for (int k = 0; k <= 32; ++k) log.push_back(twist(0.05 * k, kSpeed, kTurn));
  for (const double t : {0.3, 0.5, 0.7, 0.9, 1.1}) log.push_back(image(t));
  for (const double t : {0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6}) log.push_back(scan(t));
  test::FusionRobot robot("sensors:\n" + kGoodWheels +
                              "  - { name: front, payload: Image }\n  - { name: lidar, payload: LaserScan }\n" +
                              "initial: { x_m: 0, y_m: 0, position_sigma_m: 0.01, yaw_deg: 0, yaw_sigma_deg: 0.1 }\n" +
                              "filter: { particles: 5 }\n",
                          {}, {map_slot()});
  robot.play(test::in_order(std::move(log)));
  EXPECT_EQ(robot.events(), "");
  EXPECT_EQ(robot.report(kLidar).mapped, 7u);

  std::vector<MapDescription> maps;
  robot.fusion().visit_last([&](const Snapshot& snapshot) { maps = snapshot.best_maps(MapDetail::summary); });
  ASSERT_EQ(maps.size(), 1u);
  std::map<std::string, double> figures;
  for (const MapFigure& figure : maps[0].figures) figures[figure.name] = figure.value;
  EXPECT_EQ(figures.at("images_used"), 5.0);
  EXPECT_EQ(figures.at("images_missing"), 2.0);  // the last one is 0.3 s old by then
  EXPECT_EQ(figures.at("candidates_no_edges"), 0.0);
  EXPECT_EQ(figures.at("candidates_accepted"), 7.0);
  EXPECT_EQ(figures.at("born"), 1.0);  // the particle's own stand beside them
  ASSERT_EQ(maps[0].landmarks.size(), 1u);
  EXPECT_EQ(maps[0].landmarks[0].sightings, 7);
  EXPECT_NEAR(maps[0].landmarks[0].radius_m, 0.2, 0.008);
}

}  // namespace
}  // namespace waymark::feature_map
