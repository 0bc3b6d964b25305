// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/camera_extraction.hpp"

#include <algorithm>
#include <cmath>

#include "map_modules/feature_map/extraction/color_histogram.hpp"
#include "map_modules/feature_map/extraction/edge_pair.hpp"

namespace waymark::feature_map {

namespace {

/// Where the scan meets the axis of a candidate, if its radius is `radius`.
Eigen::Vector3d axis_of(const Candidate& candidate, double radius, const Pose& T_base_scanner) {
  const double distance = front_range(candidate, radius) + radius;
  return T_base_scanner *
         Eigen::Vector3d(distance * std::cos(candidate.bearing), distance * std::sin(candidate.bearing), 0.0);
}

std::array<Eigen::Vector2d, 4> corners_of(const UprightPatch& patch, const EdgePair& borders,
                                          const CameraView& camera) {
  const double bottom = patch.bgr.rows - 1.0;
  const auto pixel = [&](double column, double row) {
    return camera.project(patch.p_base(column, row)).value_or(Eigen::Vector2d::Zero());
  };
  return {pixel(borders.left, 0.0), pixel(borders.right, 0.0), pixel(borders.right, bottom),
          pixel(borders.left, bottom)};
}

/// What lies between the borders, without the pixels at them that are a mixture with the background.
cv::Mat inside(const UprightPatch& patch, const EdgePair& borders) {
  const double margin = 0.5 + 0.1 * (borders.right - borders.left);
  int from = static_cast<int>(std::ceil(borders.left + margin));
  int to = static_cast<int>(std::floor(borders.right - margin));
  if (from > to) from = to = static_cast<int>(std::lround(0.5 * (borders.left + borders.right)));
  return patch.bgr.colRange(from, to + 1);
}

}  // namespace

const CandidateLook* ImageLook::of(std::size_t candidate) const {
  const auto place = std::ranges::lower_bound(looks, candidate, {}, &CandidateLook::candidate);
  return place != looks.end() && place->candidate == candidate ? &*place : nullptr;
}

ImageLook CameraExtraction::look(const Measurement* image, Time stamp, const MotionWindow& motion,
                                 const Pose& T_base_scanner, std::vector<Candidate>& candidates) {
  ImageLook result;
  if (image == nullptr) return result;
  if (decoded_.state == ImageState::missing || image->stamp != decoded_stamp_ || image->sequence != decoded_sequence_) {
    decoded_ = decode(image->as<Image>(), intrinsics_);
    decoded_stamp_ = image->stamp;
    decoded_sequence_ = image->sequence;
  }
  result.image = decoded_;
  const Pose T_base_base_then = motion.relative(to_seconds(image->stamp - stamp));
  result.camera.emplace(intrinsics_, T_base_base_then * T_base_camera_);
  if (result.image.state != ImageState::used) return result;

  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Candidate& candidate = candidates[i];
    if (candidate.verdict != Verdict::accepted) continue;
    CandidateLook look;
    look.candidate = i;
    if (look_at(candidate, T_base_scanner, result, look)) {
      if (!look.has_edges) candidate.verdict = Verdict::no_edges;
      result.looks.push_back(look);
    } else if (settings_.unseen == Unseen::drop) {
      candidate.verdict = Verdict::off_image;
    }
  }
  return result;
}

bool CameraExtraction::look_at(Candidate& candidate, const Pose& T_base_scanner, const ImageLook& image,
                               CandidateLook& look) const {
  const Eigen::Vector3d axis = axis_of(candidate, candidate.radius, T_base_scanner);
  const double distance = (axis - image.camera->p_base_camera()).head<2>().norm();
  if (distance <= candidate.radius) return false;
  const double half_width = std::tan(std::asin(candidate.radius / distance));
  const double reach = std::tan(settings_.edge_search);
  const double kernel = 4.0 / intrinsics_.fx;  // the contrast of a column looks two columns to either side
  const auto patch = sample_patch(image.image.bgr, *image.camera, axis, half_width + reach + kernel,
                                  settings_.edge_below, settings_.edge_above);
  if (!patch) return false;

  const EdgePair predicted{patch->column(-half_width), patch->column(half_width)};
  const auto found = find_edge_pair(vertical_contrast(patch->bgr, settings_.edge_min_cover), predicted,
                                    {std::max(2.0, reach / patch->slope_step), settings_.edge_min_contrast,
                                     settings_.width_ratio_min, settings_.width_ratio_max});
  look.has_edges = found.has_value();
  look.corners = corners_of(*patch, found.value_or(predicted), *image.camera);
  if (!found) return true;
  measure_radius(candidate, T_base_scanner, *image.camera, patch->slope(found->left), patch->slope(found->right), look);
  look.signature = hue_saturation(inside(*patch, *found), settings_);
  return true;
}

void CameraExtraction::measure_radius(Candidate& candidate, const Pose& T_base_scanner, const CameraView& camera,
                                      double left_slope, double right_slope, CandidateLook& look) const {
  const double half = 0.5 * (std::atan(right_slope) - std::atan(left_slope));
  const double s = std::sin(half);
  // r = D s with D, from the camera to the axis, depending on r: a contraction by about s. With the camera in the
  // scanner's place its limit is r = d s/(1 − s).
  constexpr int kRounds = 20;
  double radius = candidate.radius;
  double distance = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    distance = (axis_of(candidate, radius, T_base_scanner) - camera.p_base_camera()).head<2>().norm();
    radius = distance * s;
  }
  const double width_sigma = std::sqrt(2.0) * settings_.edge_sigma_px / intrinsics_.fx;
  const double of_width = 0.5 * distance * std::cos(half) * width_sigma / (1.0 - s);
  const double of_range = range_sigma_ * s / (1.0 - s);
  candidate.surface_range = front_range(candidate, radius);
  candidate.radius = radius;
  look.radius_sigma = std::hypot(of_width, of_range);
}

}  // namespace waymark::feature_map
