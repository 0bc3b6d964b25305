// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/edge_pair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

namespace waymark::feature_map {

namespace {

constexpr int kMaxColumns = 600;
constexpr int kMaxRows = 48;
constexpr int kMinRows = 4;
constexpr int kBands = 8;

struct Edge {
  double column;  ///< with a fraction
  double score;   ///< contrast, less for what lies far from where it is expected
};

/// Local maxima of contrast between two columns.
std::vector<Edge> edges_near(const std::vector<float>& contrast, double predicted, double from, double to,
                             const EdgeSearch& search) {
  std::vector<Edge> edges;
  const int last = static_cast<int>(contrast.size()) - 2;
  for (int c = std::max(1, static_cast<int>(std::ceil(from))); c <= std::min(last, static_cast<int>(to)); ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double here = contrast[i];
    const double before = contrast[i - 1];
    const double after = contrast[i + 1];
    if (here < search.min_contrast || here < before || here <= after) continue;
    const double bend = before - 2.0 * here + after;  // < 0 at a maximum
    const double column = c + (bend < 0.0 ? 0.5 * (before - after) / bend : 0.0);
    const double off = (column - predicted) / search.reach;
    edges.push_back({column, here * std::exp(-0.5 * off * off)});
  }
  return edges;
}

}  // namespace

Eigen::Vector3d UprightPatch::p_base(double column, double row) const {
  return p_base_axis + distance * slope(column) * right + (top - row * height_step) * Eigen::Vector3d::UnitZ();
}

std::optional<UprightPatch> sample_patch(const cv::Mat& bgr, const CameraView& camera,
                                         const Eigen::Vector3d& p_base_axis, double half_slope, double below,
                                         double above) {
  constexpr double kNearest = 0.1;  // [m]
  const Eigen::Vector2d towards = (p_base_axis - camera.p_base_camera()).head<2>();
  UprightPatch patch;
  patch.distance = towards.norm();
  if (patch.distance < kNearest) return std::nullopt;
  patch.right << towards.y() / patch.distance, -towards.x() / patch.distance, 0.0;
  patch.p_base_axis = p_base_axis;
  patch.slope_step = std::max(1.0 / camera.intrinsics().fx, 2.0 * half_slope / kMaxColumns);
  patch.first_slope = -half_slope;
  patch.height_step = std::max(patch.distance / camera.intrinsics().fy, (below + above) / kMaxRows);
  const int columns = 1 + static_cast<int>(2.0 * half_slope / patch.slope_step);
  const int rows = 1 + static_cast<int>((below + above) / patch.height_step);

  // A camera sees a convex piece of the plane (nearly: lenses bend it), so the rows that it shows follow each other.
  cv::Mat map(rows, columns, CV_32FC2);
  int shown = 0;
  for (int row = 0; row < rows; ++row) {
    const double height = above - row * patch.height_step;
    if (shown == 0) patch.top = height;
    auto* places = map.ptr<cv::Vec2f>(shown);
    int column = 0;
    for (; column < columns; ++column) {
      const auto pixel = camera.project(patch.p_base(column, shown));
      if (!pixel || !camera.shows(*pixel)) break;
      places[column] = {static_cast<float>(pixel->x()), static_cast<float>(pixel->y())};
    }
    if (column == columns) {
      ++shown;
    } else if (shown > 0) {
      break;
    }
  }
  if (shown < kMinRows) return std::nullopt;
  cv::remap(bgr, patch.bgr, map.rowRange(0, shown), cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return patch;
}

std::vector<float> vertical_contrast(const cv::Mat& bgr, double min_cover) {
  std::vector<float> contrast(static_cast<std::size_t>(bgr.cols), 0.0f);
  cv::Mat real;
  bgr.convertTo(real, CV_32FC3);
  cv::Mat bands;
  cv::resize(real, bands, {bgr.cols, std::min(kBands, bgr.rows)}, 0.0, 0.0, cv::INTER_AREA);
  const auto covered = static_cast<int>(std::ceil(min_cover * bands.rows));
  std::array<float, kBands> steps{};
  const auto begin = steps.begin();
  const auto end = begin + bands.rows;
  const auto least_covered = begin + std::max(0, covered - 1);
  for (int c = 2; c + 2 < bands.cols; ++c) {
    for (int band = 0; band < bands.rows; ++band) {
      // Centred on column c, which itself is left out: an edge lies in a column, and its fraction is interpolated.
      const auto* row = bands.ptr<cv::Vec3f>(band);
      const cv::Vec3f step = 0.5f * (row[c + 1] + row[c + 2] - row[c - 1] - row[c - 2]);
      steps[static_cast<std::size_t>(band)] = std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2])});
    }
    std::nth_element(begin, least_covered, end, std::greater<>());
    contrast[static_cast<std::size_t>(c)] = *least_covered;
  }
  return contrast;
}

std::optional<EdgePair> find_edge_pair(const std::vector<float>& contrast, const EdgePair& predicted,
                                       const EdgeSearch& search) {
  const double middle = 0.5 * (predicted.left + predicted.right);
  const double width = predicted.right - predicted.left;
  const auto left = edges_near(contrast, predicted.left, predicted.left - search.reach,
                               std::min(predicted.left + search.reach, middle), search);
  const auto right = edges_near(contrast, predicted.right, std::max(predicted.right - search.reach, middle),
                                predicted.right + search.reach, search);
  std::optional<EdgePair> best;
  double most = 0.0;
  for (const Edge& l : left) {
    for (const Edge& r : right) {
      const double ratio = (r.column - l.column) / width;
      if (ratio < search.min_ratio || ratio > search.max_ratio || l.score + r.score <= most) continue;
      most = l.score + r.score;
      best = EdgePair{l.column, r.column};
    }
  }
  return best;
}

}  // namespace waymark::feature_map
