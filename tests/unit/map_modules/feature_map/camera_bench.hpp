// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "map_modules/feature_map/extraction/camera_extraction.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/math/random.hpp"

/// Images of cylinders, made ray by ray, for the tests of the camera.
namespace waymark::feature_map_test {

/// An upright cylinder in the base frame, from the ground to some height.
struct Painted {
  Eigen::Vector2d center;
  double radius;
  cv::Vec3b bgr;
  double height = 2.0;  ///< [m]
};

inline const cv::Vec3b kRedPaint(30, 30, 200);
inline const cv::Vec3b kBluePaint(200, 60, 20);

/// A scanner and a camera on a robot, and what stands before them.
struct CameraScene {
  std::vector<Painted> things;
  Intrinsics intrinsics{640, 480, 500.0, 505.0, 322.0, 238.0};
  Pose T_base_scanner{Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.6}};
  Pose T_base_camera{so3::from_rpy(0.03, 0.06, -0.02), {0.15, 0.05, 0.9}};
  double noise = 4.0;  ///< of a pixel, σ [grey levels]

  LaserScan scan() const {
    World world;
    for (const Painted& thing : things) world.cylinders.push_back({thing.center, thing.radius});
    return scan_of(world);
  }

  /// What the camera sees while the base stands at `T_base_then`, a pose in the frame in which the things stand.
  cv::Mat picture(const Pose& T_base_then = {}) const {
    cv::Mat bgr(intrinsics.height, intrinsics.width, CV_8UC3);
    const Pose T_base_eye = T_base_then * T_base_camera;
    const Eigen::Matrix3d R = T_base_eye.q.toRotationMatrix();
    Random random({.seed = 5, .slot = 0, .stamp = 0, .sensor = 0});
    for (int v = 0; v < bgr.rows; ++v) {
      for (int u = 0; u < bgr.cols; ++u) {
        const cv::Vec3b color = see(T_base_eye.p, R * direction(u, v));
        for (int k = 0; k < 3; ++k)
          bgr.at<cv::Vec3b>(v, u)[k] = cv::saturate_cast<unsigned char>(color[k] + noise * random.normal());
      }
    }
    return bgr;
  }

  Measurement image(const cv::Mat& bgr, double t = 0.0) const {
    auto payload = std::make_shared<Image>();
    payload->width = bgr.cols;
    payload->height = bgr.rows;
    payload->data.assign(bgr.datastart, bgr.dataend);
    return measurement(std::move(payload), t);
  }
  static Measurement measurement(std::shared_ptr<const Payload> payload, double t) {
    Measurement m;
    m.stamp = m.arrival = Time{from_seconds(100.0 + t)};
    m.payload = std::move(payload);
    return m;
  }

 private:
  /// Direction of a pixel in the camera's frame: the distortion undone by iteration.
  Eigen::Vector3d direction(double u, double v) const {
    const double x_seen = (u - intrinsics.cx) / intrinsics.fx;
    const double y_seen = (v - intrinsics.cy) / intrinsics.fy;
    const auto& [k1, k2, p1, p2, k3] = intrinsics.distortion;
    double x = x_seen;
    double y = y_seen;
    for (int i = 0; i < 30; ++i) {
      const double r2 = x * x + y * y;
      const double radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
      const double dx = 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
      const double dy = p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
      x = (x_seen - dx) / radial;
      y = (y_seen - dy) / radial;
      if (r2 == x * x + y * y) break;
    }
    return {1.0, -x, -y};
  }

  /// What stands in the direction `beam` from `eye`. Plain numbers: tests are compiled without optimisation, and
  /// pictures have many pixels.
  cv::Vec3b see(const Eigen::Vector3d& eye, const Eigen::Vector3d& beam) const {
    const double beam_x = beam.x();
    const double beam_y = beam.y();
    const double beam_z = beam.z();
    double nearest = std::numeric_limits<double>::infinity();
    cv::Vec3b color = beam_z > 0.0 ? cv::Vec3b(150, 140, 130) : cv::Vec3b(90, 110, 100);
    for (const Painted& thing : things) {
      const double to_x = thing.center.x() - eye.x();
      const double to_y = thing.center.y() - eye.y();
      const double a = beam_x * beam_x + beam_y * beam_y;
      const double along = beam_x * to_x + beam_y * to_y;
      const double root = along * along - a * (to_x * to_x + to_y * to_y - thing.radius * thing.radius);
      if (root < 0.0 || along <= 0.0) continue;
      const double length = (along - std::sqrt(root)) / a;
      const double z = eye.z() + length * beam_z;
      if (length >= nearest || z < 0.0 || z > thing.height) continue;
      nearest = length;
      color = thing.bgr;
    }
    return color;
  }
};

inline FeatureMapSettings camera_settings(const std::string& camera = "") {
  const Config config =
      Config::parse("{ attributes: [radius, signature], camera: { " + camera + " }, extraction: { range_max_m: 30 } }");
  const FeatureMapSettings settings = FeatureMapSettings::read(config, true);
  config.reject_unread();
  return settings;
}

/// One scan with one image, from candidates to detections.
struct LookedAt {
  std::vector<Candidate> by_scan;  ///< before the camera looked
  std::vector<Candidate> candidates;
  ImageLook look;
  FeatureObservation observation;

  LookedAt(const CameraScene& scene, const Measurement* image, const FeatureMapSettings& settings = camera_settings(),
           const MotionWindow& motion = {}) {
    const LaserScan scan = scene.scan();
    const ScanView view = view_of(scan, scene.T_base_scanner, settings.extraction);
    by_scan = candidates = examine(view, settings.extraction);
    CameraExtraction camera(scene.intrinsics, scene.T_base_camera, settings.camera.value(), settings.noise.range);
    look = camera.look(image, Time{from_seconds(100.0)}, motion, scene.T_base_scanner, candidates);
    observation = observe(scan, view, candidates, &look, scene.T_base_scanner, settings);
  }
};

}  // namespace waymark::feature_map_test
