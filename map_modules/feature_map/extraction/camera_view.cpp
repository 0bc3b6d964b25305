// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/camera_view.hpp"

namespace waymark::feature_map {

namespace {

/// The first squared radius at which d/dr of r (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) is no longer positive.
double fold_square_of(const Intrinsics& camera) {
  constexpr double kWidest = 16.0;  // 76° off the axis: no pinhole sees farther
  constexpr double kStep = 0.002;
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  for (int n = 1; n * kStep < kWidest; ++n) {
    const double r2 = n * kStep;
    if (1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) <= 0.0) return r2 - kStep;
  }
  return kWidest;
}

}  // namespace

CameraView::CameraView(const Intrinsics& intrinsics, const Pose& T_base_camera)
    : intrinsics_(intrinsics),
      T_camera_base_(T_base_camera.inverse()),
      p_base_camera_(T_base_camera.p),
      fold_square_(fold_square_of(intrinsics)) {}

std::optional<Eigen::Vector2d> CameraView::project(const Eigen::Vector3d& p_base) const {
  constexpr double kNearest = 0.05;  // [m]
  const Eigen::Vector3d p = T_camera_base_ * p_base;
  if (p.x() < kNearest) return std::nullopt;
  // The optical frame: x to the right, y down.
  const double x = -p.y() / p.x();
  const double y = -p.z() / p.x();
  const double r2 = x * x + y * y;
  if (r2 > fold_square_) return std::nullopt;
  const auto& [k1, k2, p1, p2, k3] = intrinsics_.distortion;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  return Eigen::Vector2d(intrinsics_.fx * u + intrinsics_.cx, intrinsics_.fy * v + intrinsics_.cy);
}

bool CameraView::shows(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= intrinsics_.width - 1.0 &&
         pixel.y() <= intrinsics_.height - 1.0;
}

}  // namespace waymark::feature_map
