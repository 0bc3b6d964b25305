// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/maps/octree_picture.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>
#include <unordered_set>

#include "apps/waymark/maps/octree_file.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::maps {

namespace {

constexpr std::size_t kMostVoxels = 20'000'000;
constexpr int kMarginPixels = 20;
constexpr int kMostHeightPixels = 8000;
constexpr int kFractionBits = 4;  // of a pixel, for smooth edges

using Voxel = std::array<int, 3>;

/// The voxel as one number; coordinates of an octree have 16 bits.
std::uint64_t packed(const Voxel& v) {
  constexpr int kMiddle = 1 << 17;
  std::uint64_t number = 0;
  for (const int one : v) number = (number << 18) | static_cast<std::uint64_t>(one + kMiddle);
  return number;
}

std::vector<Voxel> occupied(const octomap::OcTree& tree, const OctreeView& view) {
  std::vector<Voxel> voxels;
  const double resolution = tree.getResolution();
  const auto is_shown = [&](int layer) {
    const double middle = (layer + 0.5) * resolution;
    return middle >= view.low_m && middle < view.high_m;
  };
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (!tree.isNodeOccupied(*leaf)) continue;
    const VoxelBox box = box_of(leaf, tree);
    for (int z = box.low[2]; z < box.high[2]; ++z) {
      if (!is_shown(z)) continue;
      for (int y = box.low[1]; y < box.high[1]; ++y) {
        for (int x = box.low[0]; x < box.high[0]; ++x) voxels.push_back({x, y, z});
      }
    }
    if (voxels.size() > kMostVoxels)
      throw Error(fmt::format("more than {} occupied voxels cannot be drawn; narrow --height-m", kMostVoxels));
  }
  if (voxels.empty()) throw Error("no occupied voxel lies between these heights");
  return voxels;
}

/// Directions of a picture in the map.
struct Axes {
  Eigen::Vector3d right;
  Eigen::Vector3d up;
  Eigen::Vector3d near;  ///< towards the spectator

  explicit Axes(const OctreeView& view) {
    const double from = view.from_deg * std::numbers::pi / 180.0;
    const double tilt = view.tilt_deg * std::numbers::pi / 180.0;
    const Eigen::Vector3d there(std::cos(from), std::sin(from), 0.0);
    right = {-there.y(), there.x(), 0.0};
    up = -std::sin(tilt) * there + std::cos(tilt) * Eigen::Vector3d::UnitZ();
    near = std::cos(tilt) * there + std::sin(tilt) * Eigen::Vector3d::UnitZ();
  }
};

/// Places on the picture, in fractions of pixels.
class Sheet {
 public:
  Sheet(const Axes& axes, const std::vector<Voxel>& voxels, double resolution, int width_px) : axes_(axes) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector2d high = -low;
    for (const Voxel& v : voxels) {
      const Eigen::Vector2d p = flat(resolution * Eigen::Vector3d(v[0], v[1], v[2]));
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    low.array() -= 2.0 * resolution;
    high.array() += 2.0 * resolution;
    left_ = low.x();
    top_ = high.y();
    scale_ = (width_px - 2.0 * kMarginPixels) / (high.x() - low.x());
    const double tall = scale_ * (high.y() - low.y());
    if (tall > kMostHeightPixels) scale_ *= kMostHeightPixels / tall;
    width = static_cast<int>(std::ceil(scale_ * (high.x() - low.x()))) + 2 * kMarginPixels;
    height = static_cast<int>(std::ceil(scale_ * (high.y() - low.y()))) + 2 * kMarginPixels;
  }

  cv::Point at(const Eigen::Vector3d& p) const {
    constexpr double kOne = 1 << kFractionBits;
    const Eigen::Vector2d on = flat(p);
    return {static_cast<int>(std::lround(kOne * (kMarginPixels + scale_ * (on.x() - left_)))),
            static_cast<int>(std::lround(kOne * (kMarginPixels + scale_ * (top_ - on.y()))))};
  }

  int width = 0;
  int height = 0;

 private:
  Eigen::Vector2d flat(const Eigen::Vector3d& p) const { return {p.dot(axes_.right), p.dot(axes_.up)}; }

  const Axes& axes_;
  double left_ = 0.0;
  double top_ = 0.0;
  double scale_ = 1.0;
};

/// A colour for each layer of voxels.
class Colours {
 public:
  explicit Colours(const std::vector<Voxel>& voxels) {
    const auto [low, high] = std::ranges::minmax(voxels, {}, [](const Voxel& v) { return v[2]; });
    low_ = low[2];
    cv::Mat grey(1, high[2] - low_ + 1, CV_8U);
    for (int i = 0; i < grey.cols; ++i)
      grey.at<std::uint8_t>(i) = static_cast<std::uint8_t>(grey.cols == 1 ? 128 : 20 + 215 * i / (grey.cols - 1));
    cv::applyColorMap(grey, map_, cv::COLORMAP_TURBO);
  }
  /// Blue, green, red.
  cv::Scalar of(int layer, double brightness) const {
    return brightness * cv::Scalar(map_.at<cv::Vec3b>(layer - low_));
  }

 private:
  int low_ = 0;
  cv::Mat map_;
};

/// A side of a voxel that the spectator may see: its neighbour, and its corners.
struct Side {
  Voxel neighbour;
  std::array<Eigen::Vector3d, 4> corners;
  double brightness;
};

std::vector<Side> sides_towards(const Axes& axes) {
  std::vector<Side> sides;
  constexpr std::array<double, 3> kBrightness{0.82, 0.62, 1.0};
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(axes.near[axis]) < 1e-9) continue;
    const bool is_upper = axes.near[axis] > 0.0;
    Side side{{}, {}, kBrightness[static_cast<std::size_t>(axis)]};
    side.neighbour[static_cast<std::size_t>(axis)] = is_upper ? 1 : -1;
    const int second = (axis + 1) % 3;
    const int third = (axis + 2) % 3;
    for (std::size_t i = 0; i < 4; ++i) {
      Eigen::Vector3d corner = Eigen::Vector3d::Zero();
      corner[axis] = is_upper ? 1.0 : 0.0;
      corner[second] = i == 1 || i == 2 ? 1.0 : 0.0;
      corner[third] = i >= 2 ? 1.0 : 0.0;
      side.corners[i] = corner;
    }
    sides.push_back(side);
  }
  return sides;
}

void draw(cv::Mat& image, std::vector<Voxel> voxels, const Axes& axes, const Sheet& sheet, double resolution) {
  std::unordered_set<std::uint64_t> known;
  known.reserve(voxels.size());
  for (const Voxel& v : voxels) known.insert(packed(v));
  const auto nearness = [&](const Voxel& v) { return axes.near.dot(Eigen::Vector3d(v[0], v[1], v[2])); };
  std::ranges::sort(voxels, [&](const Voxel& a, const Voxel& b) {
    const double one = nearness(a);
    const double other = nearness(b);
    return one != other ? one < other : a < b;
  });
  const Colours colours(voxels);
  const std::vector<Side> sides = sides_towards(axes);
  for (const Voxel& v : voxels) {
    for (const Side& side : sides) {
      if (known.contains(packed({v[0] + side.neighbour[0], v[1] + side.neighbour[1], v[2] + side.neighbour[2]})))
        continue;
      std::array<cv::Point, 4> corners;
      for (std::size_t i = 0; i < 4; ++i)
        corners[i] = sheet.at(resolution * (Eigen::Vector3d(v[0], v[1], v[2]) + side.corners[i]));
      cv::fillConvexPoly(image, corners.data(), 4, colours.of(v[2], side.brightness), cv::LINE_AA, kFractionBits);
    }
  }
}

}  // namespace

Picture picture_of(const octomap::OcTree& tree, const OctreeView& view, const std::vector<Eigen::Vector3d>& path) {
  const std::vector<Voxel> voxels = occupied(tree, view);
  const Axes axes(view);
  const Sheet sheet(axes, voxels, tree.getResolution(), view.width_px);
  cv::Mat image(sheet.height, sheet.width, CV_8UC3, cv::Scalar(255, 255, 255));
  draw(image, voxels, axes, sheet, tree.getResolution());
  std::vector<cv::Point> line;
  line.reserve(path.size());
  for (const Eigen::Vector3d& p : path) line.push_back(sheet.at(p));
  if (line.size() > 1) {
    cv::polylines(image, line, false, cv::Scalar(255, 255, 255), 6, cv::LINE_AA, kFractionBits);
    cv::polylines(image, line, false, cv::Scalar(20, 20, 20), 2, cv::LINE_AA, kFractionBits);
  }
  cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
  Picture picture{image.cols, image.rows, {}};
  picture.rgb.assign(image.data, image.data + image.total() * image.elemSize());
  return picture;
}

void write_png(const Picture& picture, const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(picture.width);
  png.height = static_cast<png_uint_32>(picture.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::string bytes;
  if (png_image_write_to_memory(&png, nullptr, &size, 0, picture.rgb.data(), 0, nullptr) != 0) {
    bytes.resize(size);
    png_image_write_to_memory(&png, bytes.data(), &size, 0, picture.rgb.data(), 0, nullptr);
  }
  const std::string problem = (png.warning_or_error & PNG_IMAGE_ERROR) != 0 ? png.message : "";
  png_image_free(&png);
  if (!problem.empty()) throw Error(fmt::format("{}: {}", file.string(), problem));
  bytes.resize(size);
  write_file(file, bytes, Belongs::to_nobody);
}

}  // namespace waymark::maps
