// SPDX-License-Identifier: Apache-2.0
#include "renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

namespace waymark::simulator {
namespace {

constexpr double kColumnsPerPixel = 4.0;
constexpr float kGroundTile = 3.0f;  // [m]
constexpr float kTopShade = 1.1f;    // the upper side of a thing gets the sky's light

/// Directions of all pixel centres in the camera's frame (x forward, y left, z up), without scale.
std::vector<Eigen::Vector3d> pixel_rays(const Intrinsics& intrinsics) {
  std::vector<cv::Point2d> pixels;
  for (int v = 0; v < intrinsics.height; ++v) {
    for (int u = 0; u < intrinsics.width; ++u) pixels.emplace_back(u, v);
  }
  const cv::Matx33d K(intrinsics.fx, 0.0, intrinsics.cx, 0.0, intrinsics.fy, intrinsics.cy, 0.0, 0.0, 1.0);
  const cv::Mat distortion(1, 5, CV_64F, const_cast<double*>(intrinsics.distortion.data()));  // NOLINT: read only
  std::vector<cv::Point2d> normalized;
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-9);
  cv::undistortPoints(pixels, normalized, K, distortion, cv::noArray(), cv::noArray(), until);
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(normalized.size());
  for (const cv::Point2d& p : normalized) rays.emplace_back(1.0, -p.x, -p.y);
  return rays;
}

/// The camera's orientation without its yaw in the base.
Eigen::Quaterniond tilt(const Eigen::Quaterniond& q_base_camera) {
  return so3::from_rpy(0.0, 0.0, -so3::yaw(q_base_camera)) * q_base_camera;
}

Eigen::Vector3f sky(float slope) {
  const float up = std::min(slope, 1.0f);
  return (1.0f - up) * Eigen::Vector3f(0.88f, 0.84f, 0.8f) + up * Eigen::Vector3f(0.85f, 0.66f, 0.48f);
}

}  // namespace

const char* Renderer::refusal(const Intrinsics& intrinsics, const Eigen::Quaterniond& q_base_camera) {
  const Eigen::Quaterniond q = tilt(q_base_camera);
  const auto usable = [&](const Eigen::Vector3d& ray) {
    const Eigen::Vector3d d = (q * ray).normalized();
    // The azimuth must neither jump nor be undefined anywhere between the pixels.
    return d.allFinite() && d.x() > 0.05;
  };
  return std::ranges::all_of(pixel_rays(intrinsics), usable)
             ? ""
             : "some pixels look straight up, straight down or backwards; the simulated camera cannot";
}

Renderer::Renderer(const Intrinsics& intrinsics, const Eigen::Quaterniond& q_base_camera,
                   const std::vector<Texture>& textures)
    : pixels_(pixel_rays(intrinsics)), focal_px_(intrinsics.fx) {
  for (const Texture& texture : textures) tiles_.emplace_back(texture);
  aim(tilt(q_base_camera));
}

/// Finds azimuth and slope of all pixels. `q_tilt`: the camera's orientation without its yaw.
void Renderer::aim(const Eigen::Quaterniond& q_tilt) {
  std::vector<double> azimuths;
  azimuths.reserve(pixels_.size());
  rays_.clear();
  rays_.reserve(pixels_.size());
  for (const Eigen::Vector3d& ray : pixels_) {
    const Eigen::Vector3d d = q_tilt * ray;
    azimuths.push_back(std::atan2(d.y(), d.x()));
    rays_.push_back({0, static_cast<float>(d.z() / d.head<2>().norm())});
  }
  const auto [low, high] = std::ranges::minmax(azimuths);
  column_rad_ = 1.0 / (kColumnsPerPixel * focal_px_);
  first_azimuth_rad_ = low - 2.0 * column_rad_;
  columns_ = static_cast<std::size_t>((high - low) / column_rad_) + 6;
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    rays_[i].column = static_cast<std::uint32_t>(std::lround((azimuths[i] - first_azimuth_rad_) / column_rad_));
  }
}

void Renderer::cast_columns(const World& world, const Pose& T_map_camera, const Light& light) {
  const Eigen::Vector2d origin = T_map_camera.p.head<2>();
  const Eigen::Vector2d to_sun(std::cos(light.sun_azimuth_rad), std::sin(light.sun_azimuth_rad));
  const double yaw = T_map_camera.yaw();
  slices_.clear();
  first_slice_.assign(1, 0);
  direction_.clear();
  for (std::size_t column = 0; column < columns_; ++column) {
    const double azimuth = yaw + first_azimuth_rad_ + static_cast<double>(column) * column_rad_;
    direction_.emplace_back(static_cast<float>(std::cos(azimuth)), static_cast<float>(std::sin(azimuth)));
    world.trace(origin, azimuth, hits_);
    for (const Hit& hit : hits_) {
      const double facing = 0.5 * (1.0 + hit.outward.dot(to_sun));
      const double shade = 1.0 - light.shading * (1.0 - facing);
      slices_.push_back({static_cast<float>(hit.enter_m), static_cast<float>(hit.leave_m),
                         static_cast<float>(hit.height_m), static_cast<float>(hit.tile_u),
                         static_cast<float>(hit.tile_m), static_cast<float>(shade), &tiles_[hit.texture]});
    }
    first_slice_.push_back(slices_.size());
  }
}

Eigen::Vector3f Renderer::ground(std::size_t column, float distance_m, float slope,
                                 const Eigen::Vector3d& p_map_camera) const {
  const Eigen::Vector2f p = p_map_camera.head<2>().cast<float>() + distance_m * direction_[column];
  // A pixel covers much more along the ray than across; the tile has square footprints only.
  const float footprint = distance_m / (static_cast<float>(focal_px_) * std::sqrt(-slope) * kGroundTile);
  return tiles_.back().colour(p.x() / kGroundTile, p.y() / kGroundTile, footprint);
}

Eigen::Vector3f Renderer::look(std::size_t column, float slope, const Eigen::Vector3d& p_map_camera) const {
  const auto height = static_cast<float>(p_map_camera.z());
  const float ground_m = slope < 0.0f ? -height / slope : std::numeric_limits<float>::infinity();
  for (std::size_t i = first_slice_[column]; i < first_slice_[column + 1]; ++i) {
    const Slice& slice = slices_[i];
    if (slice.enter_m > ground_m) break;
    const float footprint = slice.enter_m / (static_cast<float>(focal_px_) * slice.tile_m);
    const float z = height + slope * slice.enter_m;
    if (z < slice.height_m) return slice.shade * slice.tile->colour(slice.tile_u, z / slice.tile_m, footprint);
    if (height + slope * slice.leave_m < slice.height_m) {
      const float top_m = (slice.height_m - height) / slope;
      return kTopShade * slice.tile->colour(slice.tile_u, top_m / slice.tile_m, footprint);
    }
  }
  return slope < 0.0f ? ground(column, ground_m, slope, p_map_camera) : sky(slope);
}

void Renderer::render(const World& world, const Pose& T_map_camera, const Light& light,
                      std::vector<Eigen::Vector3f>& image) {
  if (!world.ground.is_level()) aim(tilt(T_map_camera.q));
  cast_columns(world, T_map_camera, light);
  image.clear();
  image.reserve(rays_.size());
  const Eigen::Vector3f half_gain = 0.5f * light.gain_bgr;
  for (const PixelRay& ray : rays_) {
    // Two looks, a quarter of a pixel to each side, soften the edges as a real pixel does.
    const Eigen::Vector3f sum =
        look(ray.column - 1, ray.slope, T_map_camera.p) + look(ray.column + 1, ray.slope, T_map_camera.p);
    image.emplace_back(half_gain.cwiseProduct(sum));
  }
}

}  // namespace waymark::simulator
