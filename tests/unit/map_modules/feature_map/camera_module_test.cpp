// SPDX-License-Identifier: Apache-2.0
// The feature map as a plugin with two inputs: its configuration, its counts, and landmarks without images.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "temporary_folder.hpp"
#include "tests/unit/map_modules/feature_map/camera_bench.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::CameraScene;
using feature_map_test::kRedPaint;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class CameraModule : public ::testing::Test {
 protected:
  Rig rig(std::optional<Intrinsics> intrinsics) const {
    return Rig({{"lidar", "waymark/LaserScan@1", scene_.T_base_scanner},
                {"front", "waymark/Image@1", scene_.T_base_camera, intrinsics}});
  }
  std::shared_ptr<MapModule> make(const std::string& yaml, bool calibrated = true) const {
    const Config config = Config::parse(yaml);
    config.permit_outside();
    const auto intrinsics = calibrated ? std::optional(scene_.intrinsics) : std::nullopt;
    auto module = PluginLoader({WAYMARK_PLUGIN_DIR}).create<MapModule>("feature_map", config, rig(intrinsics));
    config.reject_unread();
    return module;
  }
  void expect_config_error(const std::string& yaml, const std::string& words, bool calibrated = true) const {
    EXPECT_THAT([&] { make(yaml, calibrated); }, ThrowsMessage<ConfigError>(HasSubstr(words)));
  }

  /// One mapping step from the origin with this image.
  void see(MapModule& module, ParticleMap& map, const Measurement* image) const {
    const Measurement scan = CameraScene::measurement(std::make_shared<LaserScan>(scene_.scan()), 0.0);
    const std::array<Companion, 1> companions{Companion{"front", image}};
    const auto observation = module.extract(scan, companions, {});
    Refinement refinement;
    map.refine({Pose{}, 1e-6 * Eigen::Matrix3d::Identity()}, Pose{}, *observation, refinement);
    map.insert({Pose{}, Eigen::Matrix3d::Zero()}, *observation, refinement.association.get());
  }
  static std::map<std::string, double> figures_of(const MapModule& module) {
    std::vector<MapFigure> figures;
    module.describe({}, figures);
    std::map<std::string, double> found;
    for (const MapFigure& figure : figures) found[figure.name] = figure.value;
    return found;
  }

  const std::string kYaml = "{ inputs: [lidar, front], attributes: [radius, signature] }";
  CameraScene scene_{{{{5.0, 0.4}, 0.2, kRedPaint}}};
};

TEST_F(CameraModule, CountsWhatBecameOfImagesAndCandidates) {
  const auto module = make(kYaml);
  const auto map = module->create_map();
  const Measurement good = scene_.image(scene_.picture());
  CameraScene empty = scene_;
  empty.things.clear();
  Measurement without = scene_.image(empty.picture());
  without.sequence = 1;
  Measurement black = scene_.image(cv::Mat::zeros(480, 640, CV_8UC3));
  black.sequence = 2;
  for (const Measurement* image : std::initializer_list<const Measurement*>{&good, &good, &without, &black})
    see(*module, *map, image);
  for (int i = 0; i < 5; ++i) see(*module, *map, nullptr);
  const auto figures = figures_of(*module);
  EXPECT_EQ(figures.at("images_used"), 3.0);
  EXPECT_EQ(figures.at("images_dark"), 1.0);
  EXPECT_EQ(figures.at("images_missing"), 5.0);
  EXPECT_EQ(figures.at("images_undecodable"), 0.0);
  EXPECT_EQ(figures.at("candidates_accepted"), 8.0);
  EXPECT_EQ(figures.at("candidates_no_edges"), 1.0);

  std::stringstream stream;
  OutArchive out(stream);
  module->save(out);
  InArchive in(stream);
  const auto restored = make(kYaml);
  restored->load(in);
  EXPECT_EQ(figures_of(*restored), figures);
}

TEST_F(CameraModule, WithoutImagesLandmarksKeepTheirAttributesAndGoOnBeingSeen) {
  const auto module = make(kYaml);
  const auto map = module->create_map();
  const Measurement good = scene_.image(scene_.picture());
  const Measurement white = scene_.image(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(255)));
  for (int i = 0; i < 3; ++i) see(*module, *map, &good);
  const auto snapshot = [&] {
    MapDescription description;
    map->describe(description);
    return description.landmarks;
  };
  ASSERT_EQ(snapshot().size(), 1u);
  EXPECT_NEAR(snapshot()[0].radius_m, 0.2, 0.006);
  for (int i = 0; i < 20; ++i) see(*module, *map, i % 2 == 0 ? nullptr : &white);
  ASSERT_EQ(snapshot().size(), 1u);
  EXPECT_EQ(snapshot()[0].sightings, 23);
  EXPECT_NEAR(snapshot()[0].radius_m, 0.2, 0.006);  // what the scan alone says is far less certain
}

TEST_F(CameraModule, WithoutACameraNothingIsSaidAboutImages) {
  const auto module = make("{ inputs: lidar }");
  for (const auto& [name, value] : figures_of(*module)) {
    EXPECT_THAT(name, ::testing::StartsWith("candidates_"));
    EXPECT_THAT(name, ::testing::Not(HasSubstr("edges")));
  }
}

TEST_F(CameraModule, RefusesAConfigurationThatCannotWork) {
  expect_config_error("{ inputs: [lidar], camera: { hue_bins: 8 } }", "none of the inputs is a camera");
  expect_config_error("{ inputs: [lidar, lidar] }", "at most one camera");
  expect_config_error("{ inputs: [lidar, front, front] }", "at most one camera");
  expect_config_error("{ inputs: [lidar, front] }", "intrinsics", false);
  expect_config_error("{ inputs: [lidar, front], camera: { hue_bins: 64, saturation_bins: 4 } }", "at most 128");
  expect_config_error("{ inputs: [lidar, front], camera: { unseen: maybe } }", "unseen");
  expect_config_error("{ inputs: [lidar, front], camera: { edge_hight_m: 1 } }", "unknown key");
  expect_config_error("{ inputs: [lidar, front], identity: known }", "identity");
  expect_config_error("{ inputs: [lidar, front], association: { signature_floor: 0.02 } }", "signature_floor");
  expect_config_error("{ inputs: [lidar, front], association: { signature_fusion: sum } }", "signature_fusion");
}

TEST_F(CameraModule, DrawsTheImageWithCandidatesRegionsAndHistograms) {
  const test::TemporaryFolder folder;
  scene_.things = {
      {{5.0, 0.6}, 0.2, kRedPaint}, {{4.0, -0.8}, 0.15, {180, 70, 30}}, {{7.0, -0.2}, 0.25, {40, 170, 60}}};
  CameraScene seen = scene_;
  seen.things.pop_back();
  const auto module =
      make("{ inputs: [lidar, front], extraction_pictures: { times_s: [0], folder: " + folder.path().string() + " } }");
  const auto map = module->create_map();
  const Measurement image = scene_.image(seen.picture());
  see(*module, *map, &image);
  EXPECT_TRUE(std::filesystem::exists(folder / "scan_0s.png"));
  const cv::Mat picture = cv::imread((folder / "camera_0s.png").string());
  ASSERT_FALSE(picture.empty());
  EXPECT_GT(picture.cols, 640);
  const auto pixels = [&](const cv::Vec3b& bgr) {
    int count = 0;
    for (auto pixel = picture.begin<cv::Vec3b>(); pixel != picture.end<cv::Vec3b>(); ++pixel)
      count += cv::norm(*pixel, bgr, cv::NORM_INF) < 12 ? 1 : 0;
    return count;
  };
  EXPECT_GT(pixels({60, 200, 40}), 200);  // two accepted
  EXPECT_GT(pixels({40, 40, 230}), 100);  // one without edges
}

}  // namespace
}  // namespace waymark::feature_map
