// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/segment_error.hpp"

#include <algorithm>

#include "waymark/math/so3.hpp"

namespace waymark::evaluation {
namespace {

constexpr std::array<double, 8> kLengthsM{100, 200, 300, 400, 500, 600, 700, 800};
constexpr double kBetweenBeginningsSeconds = 1.0;  // every tenth frame at 10 Hz

/// The distance along the reference's path to each pair [m].
std::vector<double> distances(std::span<const PosePair> pairs) {
  std::vector<double> along(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i)
    along[i] = along[i - 1] + (pairs[i].reference.p - pairs[i - 1].reference.p).norm();
  return along;
}

void make_means(SegmentErrors::Length& sums) {
  const auto count = static_cast<double>(sums.segments);
  sums.translation /= count;
  sums.rotation_rad_per_m /= count;
}

}  // namespace

SegmentErrors score_segments(std::span<const PosePair> pairs) {
  SegmentErrors out;
  const std::vector<double> along = distances(pairs);
  for (const double length : kLengthsM) {
    SegmentErrors::Length sums{length};
    std::size_t last_begin = 0;
    for (std::size_t begin = 0; begin < pairs.size(); ++begin) {
      const double since_last_s = to_seconds(pairs[begin].stamp - pairs[last_begin].stamp);
      if (begin > 0 && since_last_s < kBetweenBeginningsSeconds * (1.0 - 1e-9)) continue;
      last_begin = begin;
      const auto end =
          std::lower_bound(along.begin() + static_cast<std::ptrdiff_t>(begin), along.end(), along[begin] + length) -
          along.begin();
      if (end == static_cast<std::ptrdiff_t>(along.size())) break;
      const PosePair& a = pairs[begin];
      const PosePair& b = pairs[static_cast<std::size_t>(end)];
      const Pose moved_reference = a.reference.inverse() * b.reference;
      const Pose moved_estimate = a.estimate.inverse() * b.estimate;
      const Pose error = moved_estimate.inverse() * moved_reference;
      ++sums.segments;
      sums.translation += error.p.norm() / length;
      sums.rotation_rad_per_m += so3::log(error.q).norm() / length;
    }
    if (sums.segments == 0) continue;
    out.all.length_m += length * static_cast<double>(sums.segments);
    out.all.segments += sums.segments;
    out.all.translation += sums.translation;
    out.all.rotation_rad_per_m += sums.rotation_rad_per_m;
    make_means(sums);
    out.by_length.push_back(sums);
  }
  if (out.all.segments == 0) return out;
  out.all.length_m /= static_cast<double>(out.all.segments);
  make_means(out.all);
  return out;
}

}  // namespace waymark::evaluation
